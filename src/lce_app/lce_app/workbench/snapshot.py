# SPDX-License-Identifier: Apache-2.0
"""The bench at one moment: which topics the page shows, how often, and their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from lce_data.channels import DISPLACEMENT, POWER, SENSORS, TEMPERATURE, Channel
from lce_data.topics import COMMAND, SETPOINT, TARGET

PERIOD_S: Final = 1.0 / 15.0
WANTED: Final[Mapping[Channel, tuple[str, str]]] = {
    TEMPERATURE: (SETPOINT, "setpoint"),
    DISPLACEMENT: (TARGET, "target"),
    POWER: (COMMAND, "command"),
}
"""Topic and label of what is wanted of a channel, drawn beside what was measured."""
MONITORED: Final = (*(channel.topic for channel in (POWER, *SENSORS)), *(topic for topic, _ in WANTED.values()))
"""Topics whose values are shown."""


@dataclass(frozen=True)
class Snapshot:
    """The latest values at ``time_s`` of the node's clock.

    values : by topic, in the unit of its message (°C, m, W); a topic that was silent is left out.
    conditions : level and message of nodes that reported since the last snapshot, by name.
    """

    time_s: float
    values: dict[str, float]
    conditions: dict[str, tuple[int, str]] = field(default_factory=dict)
