# SPDX-License-Identifier: Apache-2.0
"""What became of a step of the target: the figures of Tables 6.2 and 6.3."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lce_data.errors import LceError

RISE, BAND, LATE_S = 0.8, 0.02, 30.0


@dataclass(frozen=True, slots=True)
class StepMetrics:
    """Rise time to 80 % and settling time within 2 % [s], overshoot and RMSE after 30 s [fractions of the target].

    NaN where the strip never got so far, or the step was too short to tell. The RMSE is √(Σe²/N), not (6.13) as
    printed, which falls with the number of samples.
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
