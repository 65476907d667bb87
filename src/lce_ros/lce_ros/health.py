# SPDX-License-Identifier: Apache-2.0
"""The state of a node as it goes out on /diagnostics."""

from enum import IntEnum
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from lce_ros.conversions import to_stamp


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus as numbers (its own constants are bytes)."""

    OK = 0
    WARN = 1
    ERROR = 2


class Health:
    """The present condition of a node, and its worst condition since the last message.

    So even a fault of a single tick is in the message of its second.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._now = self._worst = (Level.OK, "started")
        self.values: dict[str, Any] = {}

    def report(self, level: Level, message: str, **values: Any) -> None:
        """State the present condition; values are kept until they are stated again."""
        self._now = (level, message)
        if level >= self._worst[0]:
            self._worst = self._now
        self.values.update(values)

    def message(self, t_s: float) -> DiagnosticArray:
        """The worst condition since the last call, stamped ``t_s``."""
        level, text = self._worst
        self._worst = self._now
        values = [KeyValue(key=key, value=_text(value)) for key, value in self.values.items()]
        status = DiagnosticStatus(level=bytes([level]), name=self._name, message=text, values=values)
        array = DiagnosticArray(status=[status])
        array.header.stamp = to_stamp(t_s)
        return array


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
