# SPDX-License-Identifier: Apache-2.0
"""Spectra: at which frequencies a signal varies, and at which a model misses it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import detrend, welch

Floats = NDArray[np.float64]

SEGMENTS: Final = 4
"""A part of the run that is transformed is one of so many; they overlap by half, and are averaged."""


@dataclass(frozen=True)
class Spectrum:
    """Amplitude spectral density.

    frequency_hz : (m,) [Hz], without 0.
    density : (m,) [unit of the signal/√Hz]; its square, integrated over the frequency, is the variance.
    """

    frequency_hz: Floats
    density: Floats


def spectrum(time_s: Floats, value: Floats) -> Spectrum:
    """Amplitude spectral density by Welch's method, of what a straight line leaves.

    Parameters
    ----------
    time_s : (n,) [s], increasing; where the step is uneven, the signal is interpolated to its median.
    value : (n,).
    """
    step_s = float(np.median(np.diff(time_s)))
    even_s = np.arange(time_s[0], time_s[-1] + 0.5 * step_s, step_s)
    even = np.interp(even_s, time_s, value)
    # A line through the whole run, not through each part: the slowest part of the signal stays.
    frequency_hz, power = welch(detrend(even), 1.0 / step_s, nperseg=max(8, even.size // SEGMENTS))
    return Spectrum(frequency_hz[1:], np.sqrt(power[1:]))
