# SPDX-License-Identifier: Apache-2.0
"""What a declared parameter may be, and the sentence that refuses what it may not."""

import math
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Rule:
    """Range or choices of a parameter; ``unit`` goes into the messages.

    A parameter that is ``only_lower`` has its value from the start of its node; later it can be lowered, never raised.
    """

    name: str
    unit: str = ""
    lower: float | None = None
    upper: float | None = None
    choices: tuple[str, ...] = ()
    only_lower: bool = False

    def __post_init__(self) -> None:
        if self.lower is not None and self.upper is not None and not self.lower < self.upper:
            raise ValueError(f"{self.name}: the range [{self.lower}, {self.upper}] is empty")

    def refusal(self, value: Any, now: Any = None) -> str | None:
        """Why ``value`` is refused, naming it and the range; None if it is accepted.

        ``now`` is the present value, None before there is one.
        """
        if self.choices and value not in self.choices:
            return f"{self.name}: {value!r} is not one of {', '.join(self.choices)}"
        if isinstance(value, bool) or not isinstance(value, int | float):
            return None
        if math.isnan(value) or not self._low <= value <= self._high:
            allowed = f"[{self._low:g}, {self._high:g}]"
            return f"{self.name}: {value:g}{self._unit} is outside {allowed}{self._unit}"
        if self.only_lower and now is not None and value > now:
            return f"{self.name}: {value:g}{self._unit} is above {now:g}{self._unit}; it can only be lowered"
        return None

    @property
    def constraints(self) -> str:
        """The rule in words, for ``ros2 param describe``."""
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        if self.lower is None and self.upper is None:
            return ""
        return f"within [{self._low:g}, {self._high:g}]{self._unit}{'; can only be lowered' if self.only_lower else ''}"

    @property
    def _unit(self) -> str:
        return f" {self.unit}" if self.unit else ""

    @property
    def _low(self) -> float:
        return -math.inf if self.lower is None else self.lower

    @property
    def _high(self) -> float:
        return math.inf if self.upper is None else self.upper
