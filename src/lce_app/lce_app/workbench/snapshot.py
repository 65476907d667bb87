# SPDX-License-Identifier: Apache-2.0
"""What is heard of the bench: which topics, how often it is handed over, and a moment of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

PERIOD_S: Final = 1.0 / 15.0
HEARD: Final = (
    "temperature",
    "temperature_setpoint",
    "displacement",
    "target_displacement",
    "laser/power",
    "laser/power_command",
)
"""Topics whose values are shown."""


@dataclass(frozen=True)
class Heard:
    """What came last, at ``time_s`` of the node's clock: values by topic (°C, m, W), conditions of nodes by name."""

    time_s: float
    values: dict[str, float]
    conditions: dict[str, tuple[int, str]] = field(default_factory=dict)
