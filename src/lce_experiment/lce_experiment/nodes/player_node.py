# SPDX-License-Identifier: Apache-2.0
"""What the nodes that play an experiment share: they wait for their listeners and for the laser, keep time, and end."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from std_msgs.msg import Bool

from lce_data.errors import LceError
from lce_data.topics import ARMED
from lce_experiment.protocols import RATE_HZ
from lce_experiment.registry import LASER, arm_call
from lce_ros.health import FAULT, Level
from lce_ros.node import LceNode

_REPORT_S = 0.25
_USUAL_S = 5.0
"""Listeners that take longer to subscribe are a warning [s]."""
_REASON_S = 1.5
"""Time between a laser that is no longer armed and the end of the player [s]: a reason comes within a second."""


class Player(LceNode):
    """A node that plays for a known time, from the moment its listeners subscribe and the laser is armed.

    A fault of the laser in its namespace ends it, and so does disarming: the rest would be recorded in the dark.

    Declares patience_s, arming_patience_s, lead_s and progress. The subclass calls `begin` once; the base calls `play`
    100 times a second with the time since the beginning. Times before 0 and after `duration_s` are the lead.

    Attributes
    ----------
    played_s, total_s : seconds played and seconds in all, leads included.
    finished : whether it is over.
    """

    def __init__(self, name: str, on_finish: Callable[[], object], **options: Any) -> None:
        super().__init__(name, **options)
        self._on_finish = on_finish
        self._patience_s = self.declare(
            "patience_s", 30.0, "maximum time to wait for the listeners", unit="s", lower=0.0, read_only=True
        )
        self._arming_patience_s = self.declare(
            "arming_patience_s", 600.0, "maximum time to wait for laser/arm", unit="s", lower=0.0, read_only=True
        )
        self._lead_s = self.declare(
            "lead_s",
            0.5,
            "time before the beginning and after the end",
            unit="s",
            lower=0.1,
            upper=600.0,
            read_only=True,
        )
        self._progress = self.declare("progress", False, "print the seconds played on stdout", read_only=True)
        self._asked_s: float | None = None
        self._began_s: float | None = None
        self._reported_s = 0.0
        self._armed: bool | None = None
        self._asked_to_arm = False
        self._waiting_since_s: float | None = None
        self._dark_since_s: float | None = None
        self.played_s = self.total_s = 0.0
        self.finished = False
        self.listen_for_errors(LASER.name, self._stop)
        self.listen(Bool, ARMED, self._take_armed, latched=True)

    def begin(self, what: str, duration_s: float, listeners: Mapping[str, Sequence[str]]) -> None:
        """Play for ``duration_s`` [s] once the nodes named in ``listeners`` subscribe to its topics; log ``what``."""
        self.total_s = duration_s + 2 * self._lead_s
        self._listeners = {
            (self.resolve_topic_name(topic), name) for topic, names in listeners.items() for name in names
        }
        names = ", ".join(sorted({name for _, name in self._listeners}))
        self.get_logger().info(f"{what}; {self.total_s:g} s with the dark, {RATE_HZ:g} Hz; waiting for {names}")
        self.every(1 / RATE_HZ, self._tick)

    def play(self, time_s: float) -> None:
        """Publish what is due at ``time_s`` [s] since the beginning."""
        raise NotImplementedError

    def _stop(self, error: str) -> None:
        # A status is the worst of its second: the fault of a laser that is armed again may still be in it.
        if error.startswith(FAULT) and self._armed is not False:
            return
        raise LceError(f"{self.get_name()}: stopped by the laser: {error}")

    def _take_armed(self, message: Bool) -> None:
        self._armed = message.data
        if not message.data:
            self._dark_since_s = self.now_s() if self._dark_since_s is None else self._dark_since_s
        elif self._began_s is None:
            self._dark_since_s = None  # later, what was not played in the dark would be missing

    def _tick(self) -> None:
        now_s = self.now_s()
        if self._began_s is None:
            if not (self._all_listen(now_s) and self._may_shine(now_s)):
                return
            self._began_s = now_s
            self.tell(Level.OK, "playing")
        self.played_s = now_s - self._began_s
        if self.finished:
            return
        if self._dark_since_s is not None and now_s - self._dark_since_s > _REASON_S:
            raise LceError(f"{self.get_name()}: stopped: the laser was disarmed")
        self.play(self.played_s - self._lead_s)
        self.report(Level.OK, "playing", played_s=self.played_s, total_s=self.total_s)
        if self._progress and (self.played_s >= self._reported_s or self.played_s >= self.total_s):
            self._reported_s = self.played_s + _REPORT_S
            print(f"{min(self.played_s, self.total_s):.2f}", flush=True)
        if self.played_s >= self.total_s:
            self.finished = True
            self.tell(Level.OK, "complete")
            self._on_finish()

    def _all_listen(self, now_s: float) -> bool:
        """Whether every listener subscribes. Raises LceError when patience is over."""
        if self._asked_s is None:
            self._asked_s = now_s
        missing = self._listeners - self._subscribers()
        if not missing and self._matched():
            return True
        names = ", ".join(sorted({name for _, name in missing or self._listeners}))
        level = Level.OK if now_s - self._asked_s < _USUAL_S else Level.WARN
        self.report(level, f"waiting for {names}")
        if now_s - self._asked_s > self._patience_s:
            raise LceError(f"{self.get_name()}: no {names} after {self._patience_s:g} s")
        return False

    def _may_shine(self, now_s: float) -> bool:
        """Whether the laser is armed. Raises LceError when patience is over; it is that of a human."""
        if self._armed:
            return True
        self.report(Level.OK, "waiting for laser/arm")
        if self._waiting_since_s is None:
            self._waiting_since_s = now_s
        elif not self._asked_to_arm and now_s - self._waiting_since_s > 1.0:
            self._asked_to_arm = True
            self.get_logger().warning(f"waiting for laser/arm: {shlex.join(arm_call(self.get_namespace()))}")
        if now_s - self._waiting_since_s > self._arming_patience_s:
            raise LceError(f"{self.get_name()}: nobody armed the laser within {self._arming_patience_s:g} s")
        return False

    def _subscribers(self) -> set[tuple[str, str]]:
        """Topic and node of every subscription in this namespace to a topic that has listeners."""
        return {
            (topic, info.node_name)
            for topic in {topic for topic, _ in self._listeners}
            for info in self.get_subscriptions_info_by_topic(topic)
            if info.node_namespace == self.get_namespace()
        }

    def _matched(self) -> bool:
        """Whether the publishers have found as many subscriptions as there are listeners: only these get a message."""
        wanted = Counter(topic for topic, _ in self._listeners)
        return all(p.get_subscription_count() >= wanted[p.topic_name] for p in self.publishers)
