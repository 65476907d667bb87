# SPDX-License-Identifier: Apache-2.0
"""Node `experiment_player`: plays a protocol or a wave file as laser power, and ends.

Publishes   laser/power_command  std_msgs/Float64, W, 100 Hz, as soon as its listeners subscribe
Subscribes  laser/armed          std_msgs/Bool, latched: the player waits until it is true, and ends when it is not
            /diagnostics         diagnostic_msgs/DiagnosticArray: an error of the laser ends the player
Parameters  protocol           a PROTOCOL of `lce run --help`, one run: pulse:amp=0.2,th=30, or a wave.csv
            wait_for_recorder  wait for the laser and the recorder, not for the laser alone
            patience_s         s, maximum time to wait for them
            arming_patience_s  s, maximum time to wait for somebody to arm the laser
            lead_s             s, dark time before and after the waveform
            progress           print the seconds played on stdout, for `lce run`

The player sends the sample that belongs to the time on the node's clock, so a late timer does not stretch the
waveform. After the last sample come zeros, then the process ends with status 0.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from rclpy.utilities import try_shutdown
from std_msgs.msg import Float64

from lce_data.errors import LceError
from lce_data.topics import COMMAND
from lce_experiment import protocols
from lce_experiment.nodes.player_node import Player
from lce_experiment.registry import LASER, RECORDER
from lce_ros.node import run


class ExperimentPlayer(Player):
    """Plays one waveform."""

    reports_on = "waveform"

    def __init__(self, on_finish: Callable[[], object] = lambda: None, **options: Any) -> None:
        super().__init__("experiment_player", on_finish, **options)
        text = self.declare("protocol", "", "protocol of one run, or path of a wave.csv", read_only=True)
        recorded = self.declare("wait_for_recorder", False, "wait for the recorder too", read_only=True)
        if not text:
            raise LceError("experiment_player: parameter protocol is empty; give a protocol or a wave.csv")
        self._wave = protocols.one(text)
        self._command = self.advertise(Float64, COMMAND)
        what = f"{self._wave.text}: at most {self._wave.power_w.max():.3g} W"
        self.begin(what, self._wave.duration_s, {COMMAND: [LASER.name, *([RECORDER.name] if recorded else [])]})

    def close(self) -> None:
        """Leave the laser with a zero, however the player ends."""
        if not self.finished and self.context.ok():
            self._command.publish(Float64(data=0.0))
        super().close()

    def play(self, time_s: float) -> None:
        """Command the power of ``time_s``."""
        k = round(time_s * protocols.RATE_HZ)
        inside = 0 <= k < self._wave.power_w.size
        self._command.publish(Float64(data=float(self._wave.power_w[k]) if inside else 0.0))


def main() -> int:
    """Entry point of the executable."""
    return run(lambda: ExperimentPlayer(on_finish=try_shutdown))


if __name__ == "__main__":
    sys.exit(main())
