# SPDX-License-Identifier: Apache-2.0
"""The simulated strip: its model, and which laser power shone on it for how long."""

import math
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from lce_model import Model, default_model, load_model

LONGEST_STEP_S: Final = 0.01
LONGEST_GAP_S: Final = 60.0


class Drive:
    """Zero-order hold of the laser power between the times at which it was sent.

    A power older than ``timeout_s`` [s] counts as zero: the laser node may have been killed. A power sent at the
    very instant of a tick belongs to the time after it, so the order of the two does not matter.
    """

    def __init__(self, timeout_s: float = 0.1) -> None:
        self._timeout_s = timeout_s
        self._waiting: deque[tuple[float, float]] = deque()
        self._power_w = 0.0
        self._expires_s = -math.inf
        self._now_s: float | None = None

    @property
    def power_w(self) -> float:
        """Power [W] at the end of the last interval."""
        return self._power_w

    def put(self, power_w: float, t_s: float) -> None:
        """Take in a power [W] sent at ``t_s`` [s]; negative and non-finite ones count as zero."""
        self._waiting.append((t_s, power_w if math.isfinite(power_w) and power_w > 0.0 else 0.0))

    def advance(self, t_s: float) -> Iterator[tuple[float, float]]:
        """Pieces (power_w, dt_s) from the last time to ``t_s``, each of 10 ms at most.

        The first call, and one after a gap of more than a minute or backwards (the clock was set), only sets
        the time; what was sent before the clock was set back is dark.
        """
        if self._now_s is not None and t_s < self._now_s:
            self._waiting.clear()
            self._power_w, self._expires_s = 0.0, -math.inf
        if self._now_s is None or not 0.0 <= t_s - self._now_s <= LONGEST_GAP_S:
            self._now_s = t_s
            return
        while self._now_s < t_s:
            self._take_in(self._now_s)
            end_s = min(t_s, self._now_s + LONGEST_STEP_S, self._next_change_s())
            yield self._power_w, end_s - self._now_s
            self._now_s = end_s

    def _take_in(self, t_s: float) -> None:
        while self._waiting and self._waiting[0][0] <= t_s:
            sent_s, self._power_w = self._waiting.popleft()
            self._expires_s = sent_s + self._timeout_s
        if self._expires_s <= t_s:
            self._power_w = 0.0

    def _next_change_s(self) -> float:
        sent_s = self._waiting[0][0] if self._waiting else math.inf
        return min(sent_s, self._expires_s) if self._power_w > 0.0 else sent_s


def strip_model(model_file: str | Path, settings: Mapping[str, float]) -> Model:
    """The model of a file (empty: the default one), with settings TERM.PARAM changed as by ``Model.configured``."""
    return (load_model(model_file) if model_file else default_model()).configured(settings)
