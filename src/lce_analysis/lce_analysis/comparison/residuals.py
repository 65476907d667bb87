# SPDX-License-Identifier: Apache-2.0
"""What is left in a residual: correlation with itself and with the input, and its mean over T, dT/dt, P and cycles."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from lce_analysis.comparison.conditions import BRANCHES, OperatingConditions
from lce_analysis.options import CompareOptions

Floats = NDArray[np.float64]

CHANCE: Final = 1.96
"""Standard deviations within which 95 % of normal values lie: `Correlation` is defined by that share."""


@dataclass(frozen=True)
class Correlation:
    """Correlation coefficient (k,) at lags (k,) in s; 95 % of the values within ±band are what chance gives."""

    lag_s: Floats
    value: Floats
    band: float

    @property
    def outside(self) -> float:
        """Share of the lags, zero left out, whose correlation is outside the band: 0.05 by chance."""
        other = self.lag_s != 0.0
        return float(np.mean(np.abs(self.value[other]) > self.band)) if other.any() else 0.0


def autocorrelation(residual: Floats, step_s: float, options: CompareOptions = CompareOptions()) -> Correlation:
    """Of a residual (n,) sampled every step_s; the band is that of white noise, 1.96/√N."""
    value = _coefficients(residual, residual)
    lags = _lags(residual.size, step_s, options)
    return Correlation(
        step_s * np.arange(lags + 1.0), value[value.size // 2 :][: lags + 1], CHANCE / residual.size**0.5
    )


def cross_correlation(
    residual: Floats, drive: Floats, step_s: float, options: CompareOptions = CompareOptions()
) -> Correlation:
    """Of a residual with its input (n,); at a positive lag the residual comes after the input.

    Two smooth series that have nothing to do with each other correlate more than white noise does, so the band is
    Bartlett's, 1.96 √(Σ ρ_ee ρ_uu / N), and 1.96/√N where the residual is white.
    """
    lags = _lags(residual.size, step_s, options)
    middle = residual.size - 1
    inner = slice(middle - lags, middle + lags + 1)
    both = float(_coefficients(residual, residual)[inner] @ _coefficients(drive, drive)[inner])
    band = CHANCE * (max(both, 1.0) / residual.size) ** 0.5
    return Correlation(step_s * np.arange(-lags, lags + 1.0), _coefficients(residual, drive)[inner], min(band, 1.0))


def _coefficients(a: Floats, b: Floats) -> Floats:
    """Correlation coefficients (2n - 1,) of a with b, earlier by -(n - 1) … n - 1 samples."""
    a, b = a - a.mean(), b - b.mean()
    scale = float(np.sqrt((a @ a) * (b @ b))) or 1.0
    return np.asarray(correlate(a, b, mode="full", method="fft") / scale, dtype=np.float64)


def _lags(n: int, step_s: float, options: CompareOptions) -> int:
    return min(round(options.longest_lag_s / step_s), n // 2)


@dataclass(frozen=True)
class ResidualProfile:
    """Mean residual (k,) on each branch in bins (k,) of one quantity; NaN where there are too few samples."""

    centre: Floats
    heating: Floats
    cooling: Floats


def residual_profile(
    values: Floats, heating: NDArray[np.bool_], residual: Floats, options: CompareOptions = CompareOptions()
) -> ResidualProfile:
    """Mean of the residual (n,) over equal bins of the range of ``values`` (n,)."""
    edges = _edges(float(values.min()), float(values.max()), options.bins)
    mean = [
        _means(_bin(values[here], edges), residual[here], options.bins, options.fewest) for here in (heating, ~heating)
    ]
    return ResidualProfile(0.5 * (edges[1:] + edges[:-1]), *mean)


@dataclass(frozen=True)
class ResidualMap:
    """Mean residual (rows, k) over temperature bins with edges_c (k + 1,) °C; a row is a branch of a cycle.

    rows : cycle (from 1) and branch, in the order of time. NaN where there are too few samples.
    """

    edges_c: Floats
    rows: tuple[tuple[int, str], ...]
    mean: Floats


def residual_map(
    conditions: OperatingConditions, residual: Floats, options: CompareOptions = CompareOptions()
) -> ResidualMap:
    """The residual (n,) over temperature, cycle and branch."""
    edges = _edges(float(conditions.temperature_c.min()), float(conditions.temperature_c.max()), options.map_bins)
    index = _bin(conditions.temperature_c, edges)
    rows, means = [], []
    for cycle in np.unique(conditions.cycle):
        for branch in BRANCHES:
            here = (conditions.cycle == cycle) & (conditions.heating == (branch == "heating"))
            if here.any():
                rows.append((int(cycle), branch))
                means.append(_means(index[here], residual[here], options.map_bins, options.fewest))
    return ResidualMap(edges, tuple(rows), np.array(means))


def _edges(low: float, high: float, bins: int) -> Floats:
    """Edges (bins + 1,) of equal bins; a quantity that never changed gets one bin's width around it."""
    return np.linspace(low, high if high > low else low + 1.0, bins + 1)


def _bin(values: Floats, edges: Floats) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)


def _means(index: NDArray[np.intp], residual: Floats, bins: int, fewest: int) -> Floats:
    count = np.bincount(index, minlength=bins)
    total = np.bincount(index, weights=residual, minlength=bins)
    return np.where(count >= fewest, total / np.maximum(count, 1), np.nan)
