# SPDX-License-Identifier: Apache-2.0
"""A received value that a timer can use without racing against the message of the same instant."""

import math
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class TimedValue(Generic[T]):
    """The newest value received strictly before a given time.

    Nodes tick together, on multiples of their period. Whether the message of tick k arrives before or after the
    receiver's own tick k is a race, on simulated time as in real time. "Strictly before" makes its outcome irrelevant:
    a value is always used one tick later, and the same seed gives the same recording. Times [s] are those of the
    node's clock. If they ever fall (a simulation starts again), every value is forgotten.

    Example
    -------
    >>> power_w: TimedValue[float] = TimedValue()
    >>> power_w.put(1.5, t_s=0.01)
    >>> power_w.get(0.01) is None, power_w.get(0.02)
    (True, 1.5)
    """

    def __init__(self, limit: int = 1000) -> None:
        self._waiting: deque[tuple[float, T]] = deque(maxlen=limit)
        self._current: tuple[float, T] | None = None

    def put(self, value: T, t_s: float) -> None:
        """Take in a value received at ``t_s``."""
        newest = self._waiting[-1] if self._waiting else self._current
        if newest is not None and t_s < newest[0]:
            self.clear()
        self._waiting.append((t_s, value))

    def get(self, t_s: float) -> T | None:
        """The newest value received strictly before ``t_s``; None if there is no such value."""
        while self._waiting and self._waiting[0][0] < t_s:
            self._current = self._waiting.popleft()
        return None if self._current is None else self._current[1]

    def age(self, t_s: float) -> float:
        """Age [s] at ``t_s`` of the value that the last ``get`` returned; infinite if it returned None."""
        return math.inf if self._current is None else t_s - self._current[0]

    def clear(self) -> None:
        """Forget everything."""
        self._waiting.clear()
        self._current = None
