# SPDX-License-Identifier: Apache-2.0
"""Node `workbench`: receives the topics of the bench and hands over a snapshot of them 15 times a second.

Subscribes  temperature, displacement, laser/power, laser/power_command, temperature_setpoint, target_displacement,
            /diagnostics
"""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Final

from diagnostic_msgs.msg import DiagnosticArray

from lce_app.workbench.snapshot import MONITORED, PERIOD_S, Snapshot
from lce_data.topics import DIAGNOSTICS, LATCHED_TOPICS, RECORDED
from lce_experiment.registry import NAMESPACE
from lce_ros.messages import KINDS, MessageKind
from lce_ros.node import LceNode, run

FORGOTTEN_S: Final = 0.5
"""Age [s] at which a value is dropped; one of a latched topic stays."""


class TopicMonitorNode(LceNode):
    """See the module; ``hand_over`` is called with each snapshot."""

    def __init__(self, hand_over: Callable[[Snapshot], None], **options: Any) -> None:
        super().__init__("workbench", **options)
        self._hand_over = hand_over
        self._last: dict[str, tuple[float, float]] = {}
        self._conditions: dict[str, tuple[int, str]] = {}
        for topic in MONITORED:
            kind = KINDS[RECORDED[topic]]
            self.listen(kind.message, topic, partial(self._receive, topic, kind), latched=topic in LATCHED_TOPICS)
        self.listen(DiagnosticArray, DIAGNOSTICS, self._receive_diagnostics)
        self.every(PERIOD_S, self._tick)

    def _receive(self, topic: str, kind: MessageKind, message: Any) -> None:
        value, _ = kind.read(message)
        self._last[topic] = (self.now_s(), float(value))

    def _receive_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name != self.get_fully_qualified_name():
                self._conditions[status.name] = (status.level[0], status.message)

    def _tick(self) -> None:
        now = self.now_s()
        fresh = {
            topic: value
            for topic, (since, value) in self._last.items()
            if math.isfinite(value) and (topic in LATCHED_TOPICS or now - since < FORGOTTEN_S)
        }
        conditions, self._conditions = self._conditions, {}
        self._hand_over(Snapshot(now, fresh, conditions))


def monitor_topics(send: Connection, domain: int) -> None:
    """In a process of its own: be the node, until nobody reads the snapshots."""

    def hand_over(snapshot: Snapshot) -> None:
        try:
            send.send(snapshot)
        except BrokenPipeError:
            signal.raise_signal(signal.SIGINT)

    os.environ["ROS_DOMAIN_ID"] = str(domain)
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    run(lambda: TopicMonitorNode(hand_over), ["--ros-args", "-r", f"__ns:={NAMESPACE}"])
