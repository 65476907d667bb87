# SPDX-License-Identifier: Apache-2.0
"""Measures of misfit, as Wu (2021) defines them: fractions, not percent, of series of the same shape (n,)."""

import numpy as np
from numpy.typing import ArrayLike

from lce_data.errors import LceError
from lce_model.model import Floats


def _pair(model: ArrayLike, measured: ArrayLike) -> tuple[Floats, Floats]:
    a, b = np.asarray(model, dtype=np.float64), np.asarray(measured, dtype=np.float64)
    if a.shape != b.shape or a.size == 0:
        raise LceError(f"model and measurement differ in shape, or are empty: {a.shape} and {b.shape}")
    return a, b


def rms_error(model: ArrayLike, measured: ArrayLike) -> float:
    """√(Σe²/N), in the unit of the series: the reading of (4.18) that Tables 4.1, 4.3 and 6.2 fit."""
    a, b = _pair(model, measured)
    return float(np.sqrt(np.mean((a - b) ** 2)))


def rmse_printed(model: ArrayLike, measured: ArrayLike) -> float:
    """(1/N)·√Σe² as (4.18) is printed; falls with the number of samples. Table 5.1 fits it."""
    a, b = _pair(model, measured)
    return float(np.sqrt(np.sum((a - b) ** 2)) / a.size)


def nrmse(model: ArrayLike, measured: ArrayLike) -> float:
    """RMS error over the standard deviation of the measurement (4.24); LceError for a constant measurement."""
    a, b = _pair(model, measured)
    if np.ptp(b) == 0.0:
        raise LceError("the measurement is constant: an error relative to its spread means nothing")
    return rms_error(a, b) / float(np.std(b))


def smape(model: ArrayLike, measured: ArrayLike) -> float:
    """Σ|e|/Σ(model + measured) (4.23); meant for positive series such as λ."""
    a, b = _pair(model, measured)
    return float(np.sum(np.abs(a - b)) / np.sum(a + b))
