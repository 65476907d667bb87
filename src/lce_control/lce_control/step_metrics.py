# SPDX-License-Identifier: Apache-2.0
"""Figures of a step response: rise time, overshoot, settling time and late error of Tables 6.2 and 6.3."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lce_data.errors import LceError

RISE: Final = 0.8
"""Share of the step at which it counts as risen (Table 6.3)."""
BAND: Final = 0.02
"""Share of the target within which it counts as settled."""
LATE_S: Final = 30.0
"""Time from which the late error is taken [s] (Table 6.2)."""


@dataclass(frozen=True, slots=True)
class StepMetrics:
    """How fast and how well a step was made. A figure is NaN if the strip never got so far or the step is too short.

    Attributes
    ----------
    rise_time_s : time to 80 % of the step [s].
    overshoot : largest displacement beyond the target, in fractions of it.
    settling_time_s : time after which the error stays within 2 % of the target [s].
    rmse_after_30s : √(Σe²/N) after 30 s, in fractions of the target. (6.13) as printed falls with the number of
        samples.
    """

    rise_time_s: float
    overshoot: float
    settling_time_s: float
    rmse_after_30s: float


def step_metrics(time_s: ArrayLike, displacement_m: ArrayLike, target_m: float) -> StepMetrics:
    """Judge a step, up or down, to ``target_m`` [m] from the displacement with which the series begin.

    Parameters
    ----------
    time_s : (n,) rising [s], 0 where the target is set.
    displacement_m : (n,) [m].
    target_m : above 0 [m].

    Raises
    ------
    LceError
        If the series differ in length, or the target is not above 0.
    """
    t, d = np.asarray(time_s, dtype=np.float64), np.asarray(displacement_m, dtype=np.float64)
    if t.shape != d.shape or t.ndim != 1 or t.size == 0:
        raise LceError(f"a step needs one displacement for each time, not {d.shape} for {t.shape}")
    if not target_m > 0.0:
        raise LceError(f"target {target_m:g} m: its errors are fractions of it, it must be above 0")
    error = (d - target_m) / target_m
    step = target_m - d[0]
    risen = np.flatnonzero((d - d[0]) * math.copysign(1.0, step) >= RISE * abs(step))
    outside = np.flatnonzero(np.abs(error) > BAND)
    settled = 0 if outside.size == 0 else int(outside[-1]) + 1
    late = error[t >= LATE_S]
    return StepMetrics(
        rise_time_s=float(t[risen[0]]) if risen.size else math.nan,
        overshoot=max(0.0, float(np.max(error * math.copysign(1.0, step)))),
        settling_time_s=float(t[settled]) if settled < t.size else math.nan,
        rmse_after_30s=float(np.sqrt(np.mean(late**2))) if late.size else math.nan,
    )
