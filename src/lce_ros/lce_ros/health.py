# SPDX-License-Identifier: Apache-2.0
"""The state of a node as it goes out on /diagnostics."""

from enum import IntEnum
from typing import Any, Final

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from lce_ros.conversions import to_stamp


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus as numbers (its own constants are bytes)."""

    OK = 0
    WARN = 1
    ERROR = 2


STARTED: Final = "started"
"""The condition of a node that has not stated one."""

FAULT: Final = "fault: "
"""How an error begins that stays until somebody resets it."""


class Health:
    """The present condition of a node, and its worst condition since the last message.

    So even a fault of a single tick is in the message of its second. As in REP 107, a status is named "NODE: WHAT".

    Attributes
    ----------
    present : level and text of the present condition.
    hardware_id : which device the node speaks to; "none" for a node without a device.
    values : what the status tells besides.
    """

    def __init__(self, node: str, what: str) -> None:
        self._name = f"{node}: {what}"
        self.present = self._worst = (Level.OK, STARTED)
        self.hardware_id = "none"
        self.values: dict[str, Any] = {}

    def report(self, level: Level, message: str, **values: Any) -> None:
        """State the present condition; values are kept until they are stated again."""
        self.present = (level, message)
        if level >= self._worst[0]:
            self._worst = self.present
        self.values.update(values)

    def message(self, t_s: float) -> DiagnosticArray:
        """The worst condition since the last call, stamped ``t_s``."""
        level, text = self._worst
        self._worst = self.present
        values = [KeyValue(key=key, value=_text(value)) for key, value in self.values.items()]
        status = DiagnosticStatus(
            level=bytes([level]), name=self._name, message=text, hardware_id=self.hardware_id, values=values
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = to_stamp(t_s)
        return array


def node_of(status_name: str) -> str:
    """Full name of the node that reports a status of this name."""
    return status_name.partition(": ")[0]


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
