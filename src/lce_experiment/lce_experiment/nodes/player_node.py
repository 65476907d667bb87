# SPDX-License-Identifier: Apache-2.0
"""What the nodes that play an experiment share: they wait until all are there, keep time, and end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from lce_data.errors import LceError
from lce_experiment.protocols import RATE_HZ
from lce_ros.node import BenchNode

_REPORT_S = 0.25


class Player(BenchNode):
    """A node that acts from the moment its listeners are there, for a time that it knows, and then is finished.

    A fault of the laser in its namespace is its end: what follows would be recorded in the dark.

    Declares patience_s, lead_s and progress. `begin` is called once by the subclass, `play` by the base 100 times a
    second with the time since the beginning; what lies before 0 and after `duration_s` is the lead.

    Attributes
    ----------
    played_s, total_s : seconds played, leads included, and how many there will be.
    finished : whether it is over.
    """

    def __init__(self, name: str, on_finish: Callable[[], object], **options: Any) -> None:
        super().__init__(name, **options)
        self._on_finish = on_finish
        self._patience_s = self.declare(
            "patience_s", 30.0, "how long it waits for its listeners", unit="s", lower=0.0, read_only=True
        )
        self._lead_s = self.declare(
            "lead_s", 0.5, "dark time before and after", unit="s", lower=0.1, upper=600.0, read_only=True
        )
        self._progress = self.declare("progress", False, "print the seconds played", read_only=True)
        self._asked_s: float | None = None
        self._began_s: float | None = None
        self._reported_s = 0.0
        self.played_s = self.total_s = 0.0
        self.finished = False
        self.listen_for_errors("laser", self._stop)

    def begin(self, duration_s: float, listeners: Mapping[str, Sequence[str]]) -> None:
        """Play for ``duration_s`` [s] once the nodes named in ``listeners`` subscribe to its topics."""
        self.total_s = duration_s + 2 * self._lead_s
        self._listeners = {self.resolve_topic_name(topic): names for topic, names in listeners.items()}
        self.every(1 / RATE_HZ, self._tick)

    def play(self, time_s: float) -> None:
        """Do what belongs to ``time_s`` [s]."""
        raise NotImplementedError

    def _stop(self, error: str) -> None:
        raise LceError(f"{self.get_name()}: stopped by the laser: {error}")

    def _tick(self) -> None:
        now_s = self.now_s()
        if self._began_s is None:
            if not self._all_listen(now_s):
                return
            self._began_s = now_s
        self.played_s = now_s - self._began_s
        if self.finished:
            return
        self.play(self.played_s - self._lead_s)
        if self._progress and (self.played_s >= self._reported_s or self.played_s >= self.total_s):
            self._reported_s = self.played_s + _REPORT_S
            print(f"{min(self.played_s, self.total_s):.2f}", flush=True)
        if self.played_s >= self.total_s:
            self.finished = True
            self._on_finish()

    def _all_listen(self, now_s: float) -> bool:
        """Whether the nodes to wait for subscribe. Raises LceError when patience is over."""
        if self._asked_s is None:
            self._asked_s = now_s
        missing = [
            name
            for topic, names in self._listeners.items()
            for here in [self._subscribers(topic)]
            for name in names
            if name not in here
        ]
        matched = all(p.get_subscription_count() >= len(self._listeners.get(p.topic_name, ())) for p in self.publishers)
        if not missing and matched:
            return True
        if now_s - self._asked_s > self._patience_s:
            waited = ", ".join(dict.fromkeys(missing or [n for names in self._listeners.values() for n in names]))
            raise LceError(f"{self.get_name()}: no {waited} after {self._patience_s:g} s")
        return False

    def _subscribers(self, topic: str) -> set[str]:
        return {
            info.node_name
            for info in self.get_subscriptions_info_by_topic(topic)
            if info.node_namespace == self.get_namespace()
        }
