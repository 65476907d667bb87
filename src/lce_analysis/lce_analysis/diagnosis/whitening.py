# SPDX-License-Identifier: Apache-2.0
"""The noise of a sensor as an autoregressive process, and the filter that makes it white.

Camera and distance sensor have noise that is correlated from sample to sample, and a test that takes it for white finds
effects where none are. The process is estimated from what *no* combination of candidate effects explains (the richest
fit), else it would swallow the effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import correlate, lfilter

from lce_analysis.diagnosis.linearized_fit import spans
from lce_analysis.identification.problem import ObservedSeries
from lce_data.channels import Channel

Floats = NDArray[np.float64]

LONGEST: Final = 24
"""Highest order that is tried: it only bounds the work, as Schwarz's criterion chooses the order."""


@dataclass(frozen=True)
class Noise:
    """Autoregressive noise: e_i = φ1 e_(i-1) + … + φp e_(i-p) + σ w_i with white w.

    coefficients : (p,) φ.
    sigma : standard deviation of the innovations σ w, in the unit of the series.
    rms : standard deviation of the noise itself.
    """

    coefficients: Floats
    sigma: float
    rms: float

    @property
    def whitening(self) -> Floats:
        """The filter (p + 1,) 1 - φ1 z⁻¹ - … ."""
        return np.concatenate([[1.0], -self.coefficients])


def autoregressive(residuals: Sequence[Floats]) -> Noise:
    """Yule–Walker on the pooled autocovariance of several residuals of one sensor; the order by Schwarz's criterion.

    Those that are too short for that order do not count.
    """
    longest = min(LONGEST, max(r.size for r in residuals) // 10)
    residuals = [r for r in residuals if r.size > longest]
    total = sum(r.size for r in residuals)
    covariance = np.sum([_covariance(r - r.mean(), longest) for r in residuals], axis=0) / total
    best, least = Noise(np.empty(0), float(np.sqrt(covariance[0])), float(np.sqrt(covariance[0]))), np.inf
    for order in range(longest + 1):
        phi = solve_toeplitz(covariance[:order], covariance[1 : order + 1]) if order else np.empty(0)
        innovation = float(covariance[0] - phi @ covariance[1 : order + 1])
        if innovation <= 0.0:
            break
        criterion = total * np.log(innovation) + order * np.log(total)
        if criterion < least:
            least = criterion
            best = Noise(phi, float(np.sqrt(innovation)), float(np.sqrt(covariance[0])))
    return best


def _covariance(r: Floats, longest: int) -> Floats:
    """Sums of lagged products (longest + 1,)."""
    return np.asarray(correlate(r, r, mode="full", method="fft")[r.size - 1 : r.size + longest])


def noise_of(residual: Floats, observed: Sequence[ObservedSeries]) -> dict[Channel, Noise]:
    """Noise of each channel from a residual (N,); samples that do not count are left out."""
    parts: dict[Channel, list[Floats]] = {}
    for (begin, end), series in zip(spans(observed), observed, strict=True):
        part = residual[begin:end]
        parts.setdefault(series.channel, []).append(part if series.keep is None else part[series.keep > 0.0])
    return {channel: autoregressive(members) for channel, members in parts.items()}


def whitened(rows: Floats, residual: Floats, observed: Sequence[ObservedSeries]) -> Floats:
    """Rows (m, N) filtered series by series until ``residual`` (N,) would be white noise of variance 1."""
    noise, parts = noise_of(residual, observed), []
    for (begin, end), series in zip(spans(observed), observed, strict=True):
        own = noise[series.channel]
        parts.append(lfilter(own.whitening, np.ones(1), rows[:, begin:end])[:, own.coefficients.size :] / own.sigma)
    return np.concatenate(parts, axis=1)
