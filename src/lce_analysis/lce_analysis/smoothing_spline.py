# SPDX-License-Identifier: Apache-2.0
"""The cubic smoothing spline, smoothed as much as generalised cross-validation asks for.

This is the spline of ``scipy.interpolate.make_smoothing_spline``, compiled, because a diagnosis smooths the same
recordings many times over. λ has no upper bound as it has there, so that noise about a straight line becomes the line.
The spline minimises

    Σ (y_i - g(t_i))² + λ ∫ g''² dt,      (R + λ QᵀQ) γ = Qᵀ y,   g = y - λ Q γ      (Reinsch, Numer. Math. 10, 1967)

with the second derivatives γ at the n - 2 inner samples; R (three diagonals) and QᵀQ (five) follow from the intervals.
λ is where n Σ (y - g)² / tr(I - A)² is least (Wahba). The trace of I - A = λ Q (R + λ QᵀQ)⁻¹ Qᵀ needs five diagonals
of the inverse only (Hutchinson & de Hoog, Numer. Math. 47, 1985).
"""

from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

Floats = NDArray[np.float64]

LEAST: Final = 5
"""Fewest samples that are smoothed."""
EXPONENTS: Final = np.arange(-3.0, 15.0, 0.5)
"""log10 λ in units of the mean interval cubed at which the score is computed before it is minimised."""


def smoothing_spline(time_s: Floats, value: Floats) -> Floats:
    """The values without their noise, at their own times.

    Parameters
    ----------
    time_s, value : (n,), the times increasing; fewer than five values come back as they are.

    Returns
    -------
    (n,)
    """
    if value.size < LEAST:
        return value
    times = np.ascontiguousarray(time_s, dtype=np.float64)
    # A common scale of times and values changes neither the spline nor where the score is least.
    times = (times - times[0]) / (times[-1] - times[0]) * (times.size - 1)
    values = np.ascontiguousarray(value, dtype=np.float64)

    def score(exponent: float) -> float:
        return float(_smooth(times, values, 10.0**exponent)[1])

    start = EXPONENTS[int(np.argmin([score(x) for x in EXPONENTS]))]
    best = minimize_scalar(score, bounds=(start - 0.5, start + 0.5), method="bounded")
    fitted: Floats = _smooth(times, values, 10.0**best.x)[0]
    return fitted


@njit(cache=True)
def _smooth(t: Floats, y: Floats, strength: float) -> tuple[Floats, float]:
    """The smoothed values (n,) and the score of the generalised cross-validation."""
    n = t.size
    m = n - 2
    h = np.diff(t)
    # Column j of Q is a[j], b[j], c[j] at the samples j, j + 1, j + 2.
    a, c = 1.0 / h[:-1], 1.0 / h[1:]
    b = -a - c
    # R + λ QᵀQ = L D Lᵀ, with ones on the diagonal of L and l1, l2 below it.
    d, l1, l2 = np.empty(m), np.zeros(m), np.zeros(m)
    for j in range(m):
        diagonal = (h[j] + h[j + 1]) / 3.0 + strength * (a[j] ** 2 + b[j] ** 2 + c[j] ** 2)
        if j > 1:
            l2[j] = strength * c[j - 2] * a[j] / d[j - 2]
        if j > 0:
            beside = h[j] / 6.0 + strength * (b[j - 1] * a[j] + c[j - 1] * b[j])
            l1[j] = (beside - (l2[j] * d[j - 2] * l1[j - 1] if j > 1 else 0.0)) / d[j - 1]
        d[j] = diagonal - (l1[j] ** 2 * d[j - 1] if j > 0 else 0.0) - (l2[j] ** 2 * d[j - 2] if j > 1 else 0.0)
    g = np.empty(m)
    for j in range(m):
        g[j] = a[j] * y[j] + b[j] * y[j + 1] + c[j] * y[j + 2]
        g[j] -= (l1[j] * g[j - 1] if j > 0 else 0.0) + (l2[j] * g[j - 2] if j > 1 else 0.0)
    g /= d
    for j in range(m - 2, -1, -1):
        g[j] -= l1[j + 1] * g[j + 1] + (l2[j + 2] * g[j + 2] if j + 2 < m else 0.0)
    rough = np.zeros(n)
    for j in range(m):
        rough[j] += a[j] * g[j]
        rough[j + 1] += b[j] * g[j]
        rough[j + 2] += c[j] * g[j]
    # Diagonals of the inverse, from its last row up: v0 = (j, j), v1 = (j, j + 1), v2 = (j, j + 2).
    freedom, below, below1, after = 0.0, 0.0, 0.0, 0.0  # of rows j + 1: v0, v1; of row j + 2: v0
    for j in range(m - 1, -1, -1):
        first = l1[j + 1] if j + 1 < m else 0.0
        second = l2[j + 2] if j + 2 < m else 0.0
        v2 = -first * below1 - second * after
        v1 = -first * below - second * below1
        v0 = 1.0 / d[j] - first * v1 - second * v2
        freedom += (a[j] ** 2 + b[j] ** 2 + c[j] ** 2) * v0
        if j + 1 < m:
            freedom += 2.0 * (b[j] * a[j + 1] + c[j] * b[j + 1]) * v1
        if j + 2 < m:
            freedom += 2.0 * c[j] * a[j + 2] * v2
        after, below, below1 = below, v0, v1
    residual = strength * rough
    score = n * np.sum(residual**2) / (strength * freedom) ** 2
    return y - residual, score
