# SPDX-License-Identifier: Apache-2.0
"""The spectrum of unevenly sampled series, beside the smooth background that coloured noise and smooth misfit give."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lombscargle

Floats = NDArray[np.float64]

FINE: Final = 3.0
"""Frequencies for each resolved one."""
EULER: Final = 0.5772
"""Minus the mean logarithm of an exponential variate: by so much a mean of logarithms underestimates a spectrum."""
LOBE: Final = 2.0
"""Half width of a line behind a Hann window, in 1/duration."""
BESIDE: Final = 8.0
"""Least half width of the background beside a line, in 1/duration."""
OCTAVES: Final = 1.0
"""The same at higher frequencies."""


def spectrum(time_s: Floats, values: Floats, frequencies_hz: Floats) -> Floats:
    """Power (m,) of values (n,) at frequencies (m,) by Lomb and Scargle, behind a Hann window, without their trend.

    A sine of amplitude a gives a² at its frequency.
    """
    begin, duration = time_s[0], time_s[-1] - time_s[0]
    place = (time_s - begin) / duration
    window = np.maximum(np.sin(np.pi * place) ** 2, 1e-6)
    trend = np.vander(2.0 * place - 1.0, 4)
    rest = values - trend @ np.linalg.lstsq(trend, values, rcond=None)[0]
    amplitude = lombscargle(
        time_s - begin, rest, 2.0 * np.pi * frequencies_hz, normalize="amplitude", weights=window, floating_mean=True
    )
    return np.abs(np.asarray(amplitude)) ** 2


def background(frequencies_hz: Floats, power: Floats, duration_s: float) -> Floats:
    """The smooth part (m,) of a spectrum (m,): a straight line in logarithms through what lies beside each frequency.

    A line hides itself neither from its own background nor its neighbours': the main lobe is left out.
    """
    x, y = np.log(frequencies_hz), np.log(np.maximum(power, 1e-300))
    half = np.maximum(BESIDE / duration_s, frequencies_hz * (2.0**OCTAVES - 1.0))
    outer = _sums(frequencies_hz, x, y, np.maximum(BESIDE / duration_s, 0.5 * frequencies_hz), half)
    lobe = np.full(frequencies_hz.size, LOBE / duration_s)
    n, sx, sy, sxx, sxy = outer - _sums(frequencies_hz, x, y, lobe, lobe)
    spread = np.maximum(n * sxx - sx**2, 1e-12)
    slope = np.where(n > 2.0, (n * sxy - sx * sy) / spread, 0.0)
    level = (sy - slope * sx) / np.maximum(n, 1.0)
    return np.asarray(np.exp(level + slope * x + EULER))


def _sums(f: Floats, x: Floats, y: Floats, below: Floats, above: Floats) -> Floats:
    """Count and moments (5, m) of x and y from f - below to f + above."""
    first, last = np.searchsorted(f, f - below), np.searchsorted(f, f + above, side="right")
    rows = np.stack([np.ones_like(x), x, y, x * x, x * y])
    running = np.concatenate([np.zeros((5, 1)), np.cumsum(rows, axis=1)], axis=1)
    return np.asarray(running[:, last] - running[:, first])
