# SPDX-License-Identifier: Apache-2.0
"""Node `workbench`: hears the topics of the bench and hands over, 15 times a second, what came last.

Subscribes  temperature, displacement, laser/power, laser/power_command, temperature_setpoint, target_displacement,
            /diagnostics
"""

from __future__ import annotations

import importlib
import math
import os
import signal
from collections.abc import Callable
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Final

from diagnostic_msgs.msg import DiagnosticArray

from lce_app.workbench.snapshot import HEARD, PERIOD_S, Heard
from lce_data.topics import LATCHED_TOPICS, RECORDED
from lce_experiment.graph import NAMESPACE
from lce_experiment.runners.processes import end_with_parent
from lce_ros.node import BenchNode, run

FORGOTTEN_S: Final = 0.5
"""A value older than this is no value any more; one that is latched holds."""


class Live(BenchNode):
    """See the module; ``tell`` is called with what was heard."""

    def __init__(self, tell: Callable[[Heard], None], **options: Any) -> None:
        super().__init__("workbench", **options)
        self._tell = tell
        self._last: dict[str, tuple[float, float]] = {}
        self._conditions: dict[str, tuple[int, str]] = {}
        for topic in HEARD:
            package, _, name = RECORDED[topic].split("/")
            kind = getattr(importlib.import_module(f"{package}.msg"), name)
            self.listen(kind, topic, partial(self._hear, topic), latched=topic in LATCHED_TOPICS)
        self.listen(DiagnosticArray, "/diagnostics", self._diagnose)
        self.every(PERIOD_S, self._hand_over)

    def _hear(self, topic: str, message: Any) -> None:
        value = message.temperature if hasattr(message, "temperature") else message.data
        self._last[topic] = (self.now_s(), float(value))

    def _diagnose(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self.get_fully_qualified_name():
                continue
            self._conditions[status.name] = (status.level[0], status.message)

    def _hand_over(self) -> None:
        now = self.now_s()
        fresh = {
            topic: value
            for topic, (since, value) in self._last.items()
            if math.isfinite(value) and (topic in LATCHED_TOPICS or now - since < FORGOTTEN_S)
        }
        conditions, self._conditions = self._conditions, {}
        self._tell(Heard(now, fresh, conditions))


def listen(send: Connection, domain: int) -> None:
    """In a process of its own: be the node, until nobody takes in what it tells."""

    def tell(heard: Heard) -> None:
        try:
            send.send(heard)
        except BrokenPipeError:
            signal.raise_signal(signal.SIGINT)

    end_with_parent()
    os.environ["ROS_DOMAIN_ID"] = str(domain)
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    run(lambda: Live(tell), ["--ros-args", "-r", f"__ns:={NAMESPACE}"])
