# SPDX-License-Identifier: Apache-2.0
"""A received value that a timer can use without racing against the message of the same instant."""

import math
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class TimedValue(Generic[T]):
    """The newest value received strictly before a given time.

    Nodes tick together, on multiples of their period. Whether the message of tick k arrives before or after
    the receiver's own tick k is then a race, in lockstep simulated time as in real time; with "strictly
    before" its outcome does not matter: a value is used one tick later, always, and the same seed gives the
    same recording. Times [s] are the node clock's and never fall; when they do all the same (a simulation
    starts again), what was held is forgotten.
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
        """The newest value received strictly before ``t_s``; None where there is none."""
        while self._waiting and self._waiting[0][0] < t_s:
            self._current = self._waiting.popleft()
        return None if self._current is None else self._current[1]

    def age(self, t_s: float) -> float:
        """How long before ``t_s`` [s] the value of the last ``get`` was received; infinite without one."""
        return math.inf if self._current is None else t_s - self._current[0]

    def clear(self) -> None:
        """Forget everything."""
        self._waiting.clear()
        self._current = None
