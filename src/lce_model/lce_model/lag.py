# SPDX-License-Identifier: Apache-2.0
"""What several effects share: the first-order lag, of a step and of a series, and a change at a time."""

import math

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray


@register_jitable
def lag(late: float, before: float, now: float, dt: float, tau: float) -> float:
    """First-order lag: ``late`` after a step of ``dt`` [s] with the time constant ``tau`` [s]; ``now`` at tau = 0.

    Exact for a value that goes straight from ``before`` to ``now``, so that it is smooth in tau down to zero.
    """
    if tau == 0.0:
        return now
    if dt == 0.0:
        return late
    ratio = dt / tau
    return now + (late - before) * math.exp(-ratio) + (now - before) * math.expm1(-ratio) / ratio


@register_jitable
def share_after(time: float, before: float, after: float) -> float:
    """Share of the step from ``before`` to ``after`` [s] that lies behind ``time`` [s]."""
    if after <= time:
        return 0.0
    return 1.0 if before >= time else (after - time) / (after - before)


@njit(cache=True)
def lagged(time_s: NDArray[np.float64], value: NDArray[np.float64], tau: float, held: bool) -> NDArray[np.float64]:
    """What a first-order lag makes of a series (n,) that begins at rest; ``held`` values stay until the next time."""
    late = value.copy()
    for i in range(1, value.size):
        before = value[i] if held else value[i - 1]
        late[i] = lag(late[i - 1], before, value[i], time_s[i] - time_s[i - 1], tau)
    return late
