# SPDX-License-Identifier: Apache-2.0
"""Node `target_player`: sets targets at their times, and ends.

Publishes   target_displacement  std_msgs/Float64, m, latched, on change
Subscribes  laser/armed          std_msgs/Bool, latched: the player waits until it is true, and ends when it is not
            /diagnostics         diagnostic_msgs/DiagnosticArray: an error of the laser ends the player
Parameters  time_s             s, when each target is set; rising, from 0
            target_m           m, the targets
            duration_s         s, when the last one ends
            wait_for           nodes that must subscribe to the targets
            wait_for_recorder  wait until the recorder has a message of each sensor
            patience_s         s, maximum time to wait for them
            arming_patience_s  s, maximum time to wait for somebody to arm the laser
            lead_s             s, time without a target before, and with the last one after
            progress           print the seconds played on stdout, for `lce control`

The controllers bring the power to zero when they end.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
from rclpy.utilities import try_shutdown
from std_msgs.msg import Float64

from lce_data.errors import LceError
from lce_data.topics import COMMAND, TARGET
from lce_experiment.nodes.player_node import Player
from lce_experiment.registry import RECORDER
from lce_ros.health import FAULT
from lce_ros.node import run


class TargetPlayer(Player):
    """Plays targets, each held until the next."""

    reports_on = "targets"

    def __init__(self, on_finish: Callable[[], object] = lambda: None, **options: Any) -> None:
        super().__init__("target_player", on_finish, **options)
        self._time_s = np.array(self.declare("time_s", [0.0], "when each target is set [s]", read_only=True))
        self._target_m = np.array(self.declare("target_m", [0.0], "targets [m]", read_only=True))
        duration_s = self.declare("duration_s", 60.0, "when the last target ends", unit="s", lower=0.0, read_only=True)
        wait_for = [
            name
            for name in self.declare("wait_for", [""], "nodes that must subscribe to the targets", read_only=True)
            if name
        ]
        recorded = self.declare("wait_for_recorder", False, "wait for the recorder too", read_only=True)
        if self._time_s.size != self._target_m.size or (np.diff(self._time_s) <= 0.0).any():
            raise LceError("target_player: needs one target for each time, and times that rise")
        if not (np.isfinite(self._time_s).all() and np.isfinite(self._target_m).all()):
            raise LceError("target_player: time_s and target_m: every number must be finite")
        for name in wait_for:
            self.listen_for_errors(name, functools.partial(self._judge, name))
        self._set: float | None = None
        self._target = self.advertise(Float64, TARGET, latched=True)
        # The recorder subscribes to commands once it has a message of each sensor.
        what = f"targets of {', '.join(f'{1e3 * target:g}' for target in self._target_m)} mm"
        self.begin(what, duration_s, {TARGET: wait_for, COMMAND: [RECORDER.name] if recorded else []})

    def play(self, time_s: float) -> None:
        """Publish the target of ``time_s`` [s] if it is another one."""
        row = int(np.searchsorted(self._time_s, time_s + 1e-6, side="right")) - 1
        if row >= 0 and self._target_m[row] != self._set:
            self._set = float(self._target_m[row])
            self._target.publish(Float64(data=self._set))

    def _judge(self, controller: str, error: str) -> None:
        if error.startswith(FAULT):
            raise LceError(f"{self.get_name()}: stopped by {controller}: {error}")


def main() -> int:
    """Entry point of the executable."""
    return run(lambda: TargetPlayer(on_finish=try_shutdown))


if __name__ == "__main__":
    sys.exit(main())
