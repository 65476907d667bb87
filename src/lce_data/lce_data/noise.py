# SPDX-License-Identifier: Apache-2.0
"""Estimate the noise of a measured series from the series alone: what its sensor adds, whatever a model says."""

import math
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.stats import chi2

from lce_data.channels import Channel
from lce_data.run import Run, Series

Floats = NDArray[np.float64]

_THIRD_DIFFERENCE_GAIN: Final = math.sqrt(20.0)
"""Standard deviation of x3 - 3 x2 + 3 x1 - x0 over that of white noise x."""
_ROUNDING: Final = math.sqrt(12.0)
"""Quantisation step over the standard deviation of its rounding error."""
_MAD_TO_RMS: Final = 1.4826
_WINDOWS: Final = (16, 32, 64, 128)
"""Samples in which a cubic stands for the signal."""
_CALM: Final = 0.2
"""Share of the windows in which the cubic has to be enough."""
_GROWTH: Final = 1.5
"""What the estimate may grow by from the shortest window to the next: the slower the noise, the more."""
_STEADY: Final = 1.15
"""It may always grow by this."""
_SLACK: Final = 1.05
"""Noise makes it grow less with every doubling, but for this scatter; the signal makes it grow more."""
_PHI: Final = np.linspace(0.0, 0.96, 49)
"""Correlation of autoregressive noise from sample to sample, as far as it can be told from the signal."""
_FIRST: Final = 5.0
"""Growth from third differences, which hardly see correlated noise, to the shortest window."""
_MOST: Final = 2000
"""Windows of one length that are looked at: more would not change the estimate."""


def noise_floor(series: Series) -> float:
    """RMS of the noise that the sensor adds, in the unit of the series.

    White noise is estimated from third differences, in which a smooth signal vanishes. Noise that is correlated from
    sample to sample shows in longer windows: there the residual of a cubic counts, in the calmest fifth of the windows,
    so that corners of the signal stay out of it. The window grows up to 128 samples as long as the estimate grows as
    noise does. Noise slower than that cannot be told from the signal. A quantised series has at least the rounding
    noise of its step q, q/√12. The result is never zero: a series without noise gives 1e-6 of its range.
    """
    value = series.value
    smallest = 1e-6 * max(float(np.ptp(value)), 1e-6 * float(np.max(np.abs(value))), 1e-12)
    if value.size < 8:
        return smallest
    third = np.abs(np.diff(value, 3))
    noise = max(_MAD_TO_RMS * float(np.median(third)) / _THIRD_DIFFERENCE_GAIN, 1e-300)
    growth = _FIRST
    for window in _WINDOWS:
        longer = _rms_around_cubic(value, window)
        if longer > growth * noise:
            break
        growth = _GROWTH if growth == _FIRST else max(_SLACK * longer / noise, _STEADY)
        noise = max(noise, longer)
    return max(noise, _quantum(value) / _ROUNDING, smallest)


def _quantum(value: Floats) -> float:
    """The step of a series that repeats its values, else 0."""
    steps = np.abs(np.diff(value))
    repeated = float(np.mean(steps == 0.0))
    return float(np.min(steps[steps > 0.0])) if 0.2 < repeated < 1.0 else 0.0


def _rms_around_cubic(value: Floats, window: int) -> float:
    """RMS noise by the residual of a cubic in the calmest windows; infinite where the series is too short for that.

    The cubic takes a part of the noise with it, the more the longer that is correlated. How much follows from the
    correlation of the residual from sample to sample, as if the noise were autoregressive of first order.
    """
    if value.size < 8 * window:
        return math.inf
    every = max(window // 4, value.size // _MOST)
    parts = sliding_window_view(value, window)[::every]
    rest = (parts - parts.mean(axis=1, keepdims=True)) @ _without_cubic(window)
    energy = np.sum(rest**2, axis=1)
    calm = rest[energy <= np.quantile(energy, 0.5)]
    total = float(np.sum(calm**2))
    seen = float(np.sum(calm[:, 1:] * calm[:, :-1])) / total if total > 0.0 else 0.0
    memory, left = _autoregressive(window)
    i = int(np.argmin(np.abs(memory - seen)))
    phi = float(_PHI[i])
    freedom = max((window - 4) * (1.0 - phi**2) / (1.0 + phi**2), 2.0)
    expected = float(chi2.ppf(_CALM, freedom)) / freedom
    return math.sqrt(float(np.quantile(energy, _CALM)) / expected / float(left[i]))


@cache
def _without_cubic(window: int) -> Floats:
    """Projection (window, window) that removes a cubic."""
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, window), 4))
    return np.asarray(np.eye(window) - basis @ basis.T)


@cache
def _autoregressive(window: int) -> tuple[Floats, Floats]:
    """For each of _PHI: correlation from sample to sample after the cubic is removed, and the variance left (sum)."""
    lag = np.abs(np.subtract.outer(np.arange(window), np.arange(window)))
    projection = _without_cubic(window)
    covariances = [projection @ phi**lag @ projection for phi in _PHI]
    left = np.array([np.trace(c) for c in covariances])
    return np.array([np.trace(c, offset=1) for c in covariances]) / left, left


def sensor_noise(runs: Sequence[Run], channels: Iterable[Channel]) -> dict[Channel, float]:
    """RMS noise [SI] of each channel over the runs that measured it; channels that no run measured are left out."""
    floors = {c: [noise_floor(run.series[c]) for run in runs if c in run.series] for c in channels}
    return {c: float(np.sqrt(np.mean(np.square(values)))) for c, values in floors.items() if values}
