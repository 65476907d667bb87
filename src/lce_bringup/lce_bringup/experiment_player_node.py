# SPDX-License-Identifier: Apache-2.0
"""Node `experiment_player`: plays a protocol or a wave file as laser power, and ends.

Publishes   laser/power_command  std_msgs/Float64, W, 100 Hz from the moment all are there
Parameters  protocol     a PROTOCOL of `lce run --help`, one run: pulse:amp=0.2,th=30, or a wave.csv
            wait_for_recorder  begin only when the recorder listens too, and not the laser alone
            patience_s   s, how long it waits for them
            lead_s       s, dark time before and after the waveform
            progress     print the seconds played on stdout, for `lce run`

The sample that is sent is the one that belongs to the time on the node's clock, so a late timer does not
stretch the waveform. After the last one come zeros, then the process ends with status 0.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from rclpy.utilities import try_shutdown
from std_msgs.msg import Float64

from lce_bringup import protocols
from lce_bringup.topics import COMMAND
from lce_model.errors import LceError
from lce_ros.node import BenchNode, run

_REPORT_S = 0.25


class ExperimentPlayer(BenchNode):
    """Plays one waveform. `finished` is True once it is over; `played_s` runs from 0 to `total_s`."""

    def __init__(self, on_finish: Callable[[], object] = lambda: None, **options: Any) -> None:
        super().__init__("experiment_player", **options)
        self._on_finish = on_finish
        text = self.declare("protocol", "", "protocol or path of a wave.csv", read_only=True)
        recorded = self.declare("wait_for_recorder", False, "begin only with the recorder", read_only=True)
        self._wait_for = ["laser", "recorder"] if recorded else ["laser"]
        patience_s = self.declare("patience_s", 30.0, "how long it waits", unit="s", lower=0.0, read_only=True)
        lead_s = self.declare(
            "lead_s", 0.5, "dark time before and after", unit="s", lower=0.1, upper=600.0, read_only=True
        )
        self._progress = self.declare("progress", False, "print the seconds played", read_only=True)
        if not text:
            raise LceError("experiment_player: parameter protocol is empty; give a protocol or a wave.csv")
        self._wave = protocols.one(text)
        self._lead_s = lead_s
        self._patience_s = patience_s
        self._asked_s: float | None = None
        self._began_s: float | None = None
        self._reported_s = 0.0
        self.played_s = 0.0
        self.total_s = self._wave.duration_s + 2 * lead_s
        self.finished = False
        self._command = self.advertise(Float64, COMMAND)
        self.every(1 / protocols.RATE_HZ, self._tick)

    def close(self) -> None:
        """Leave the laser with a zero, however it ends."""
        if not self.finished and self.context.ok():
            self._command.publish(Float64(data=0.0))
        super().close()

    def _tick(self) -> None:
        now_s = self.now_s()
        if self._began_s is None:
            if not self._all_listen(now_s):
                return
            self._began_s = now_s
        self.played_s = now_s - self._began_s
        if self.finished:
            return
        self._command.publish(Float64(data=self._power_w(self.played_s - self._lead_s)))
        if self._progress and (self.played_s >= self._reported_s or self.played_s >= self.total_s):
            self._reported_s = self.played_s + _REPORT_S
            print(f"{min(self.played_s, self.total_s):.2f}", flush=True)
        if self.played_s >= self.total_s:
            self.finished = True
            self._on_finish()

    def _power_w(self, time_s: float) -> float:
        k = round(time_s * protocols.RATE_HZ)
        return float(self._wave.power_w[k]) if 0 <= k < self._wave.power_w.size else 0.0

    def _all_listen(self, now_s: float) -> bool:
        """Whether the nodes to wait for subscribe to the command. Raises LceError when patience is over."""
        if self._asked_s is None:
            self._asked_s = now_s
        here = {
            info.node_name
            for info in self.get_subscriptions_info_by_topic(self._command.topic_name)
            if info.node_namespace == self.get_namespace()
        }
        missing = [name for name in self._wait_for if name not in here]
        if not missing and self._command.get_subscription_count() >= len(self._wait_for):
            return True
        if now_s - self._asked_s > self._patience_s:
            waited = ", ".join(missing or self._wait_for)
            raise LceError(f"experiment_player: no {waited} after {self._patience_s:g} s")
        return False


def main() -> int:
    """Entry point of the executable."""
    return run(lambda: ExperimentPlayer(on_finish=try_shutdown))


if __name__ == "__main__":
    sys.exit(main())
