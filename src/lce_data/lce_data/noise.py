# SPDX-License-Identifier: Apache-2.0
"""Estimate the noise of a measured series from the series alone."""

import math
from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np

from lce_data.channels import Channel
from lce_data.run import Run, Series

_THIRD_DIFFERENCE_GAIN: Final = math.sqrt(20.0)
"""Standard deviation of x3 - 3 x2 + 3 x1 - x0 over that of white noise x."""
_ROUNDING: Final = math.sqrt(12.0)
"""Quantisation step over the standard deviation of its rounding error."""
_MAD_TO_RMS: Final = 1.4826


def noise_floor(series: Series) -> float:
    """RMS of the sample-to-sample noise, in the unit of the series.

    The estimate is made from third differences, in which a smooth signal vanishes; their median keeps corners of the
    signal out of it. A quantised series has at least the rounding noise of its step q, q/√12. Noise that is correlated
    from sample to sample is underestimated. The result is never zero: a series without noise gives 1e-6 of its range.
    """
    value = series.value
    smallest = 1e-6 * max(float(np.ptp(value)), 1e-6 * float(np.max(np.abs(value))), 1e-12)
    if value.size < 8:
        return smallest
    third = np.abs(np.diff(value, 3))
    steps = np.abs(np.diff(value))
    repeated = float(np.mean(steps == 0.0))
    quantum = float(np.min(steps[steps > 0.0])) if 0.2 < repeated < 1.0 else 0.0
    return max(_MAD_TO_RMS * float(np.median(third)) / _THIRD_DIFFERENCE_GAIN, quantum / _ROUNDING, smallest)


def sensor_noise(runs: Sequence[Run], channels: Iterable[Channel]) -> dict[Channel, float]:
    """RMS noise [SI] of each channel over the runs that measured it; channels that no run measured are left out."""
    floors = {c: [noise_floor(run.series[c]) for run in runs if c in run.series] for c in channels}
    return {c: float(np.sqrt(np.mean(np.square(values)))) for c, values in floors.items() if values}
