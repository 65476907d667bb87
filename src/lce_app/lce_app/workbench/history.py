# SPDX-License-Identifier: Apache-2.0
"""The last minutes of a series that is watched."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray

KEPT_S: Final = 300.0
"""How long samples are kept [s]."""
Times = NDArray[np.float64]
Values = NDArray[np.float32]


class History:
    """Batches of samples as they came; ``count`` is how many samples there have been."""

    def __init__(self) -> None:
        self.count = 0
        self._batches: deque[tuple[Times, Values]] = deque()

    def add(self, time_s: Times, value: Values) -> None:
        """Append samples (n,), and forget those of five minutes ago."""
        if not time_s.size:
            return
        self._batches.append((time_s, value))
        self.count += time_s.size
        while self._batches[0][0][-1] < time_s[-1] - KEPT_S:
            self._batches.popleft()

    def since(self, count: int) -> tuple[Times, Values]:
        """Times [s] and values (n,) of the samples after the first ``count``, as far as they are kept."""
        new: list[tuple[Times, Values]] = []
        missing = self.count - count
        for batch in reversed(self._batches):
            if missing <= 0:
                break
            new.append((batch[0][-missing:], batch[1][-missing:]))
            missing -= batch[0].size
        times, values = zip(*reversed(new), strict=True) if new else ((np.empty(0),), (np.empty(0, np.float32),))
        return np.concatenate(times), np.concatenate(values)
