# SPDX-License-Identifier: Apache-2.0
"""What several effects share: the first-order lag, and a change at a time."""

import math

from numba.extending import register_jitable


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
