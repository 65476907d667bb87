# SPDX-License-Identifier: Apache-2.0
"""The score test: which direction of the library would take the residual away, before anything is refitted.

With residuals r = W(y - f), Jacobian J = W ∂f/∂θ of the free parameters and g = W ∂f/∂β of an effect of
strength β, and M = I - J(JᵀJ)⁻¹Jᵀ, which projects the free parameters out (Rao's score, or Lagrange multiplier, test):

- evidence LM = (gᵀMr)² / (s² gᵀMg), χ² with one degree of freedom where the effect is absent;
- expected strength β̂ = gᵀMr / gᵀMg, and s² LM the reduction of the squared error that it predicts;
- visibility gᵀMg / gᵀg: near 0 the free parameters mask the effect;
- aliasing ρ_jk = g_jᵀMg_k / √(g_jᵀMg_j g_kᵀMg_k): near ±1 two effects look alike in these data.

Evidence and visibility are of whitened residuals. For all else W only divides by the sensors' noise, the metric in
which refits are made and compared.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

Floats = NDArray[np.float64]

RANK: Final = 1e-11
"""Eigenvalues of a scaled JᵀJ below this part of the largest belong to combinations that the data do not determine."""


@dataclass(frozen=True)
class Projection:
    """Inner products of directions (k,) and the residual, before and after the free parameters are projected out.

    solve : (free, k + 1) least-squares coefficients of the free parameters on directions and residual.
    before, after : (k + 1, k + 1), the residual last.
    """

    solve: Floats
    before: Floats
    after: Floats

    @property
    def error(self) -> float:
        """Squared whitened residual that the free parameters leave."""
        return float(self.after[-1, -1])

    @property
    def strength(self) -> Floats:
        """β̂ (k,) of each direction alone."""
        norm = np.diag(self.after)[:-1]
        return np.asarray(np.where(norm > 0.0, self.after[:-1, -1] / np.where(norm > 0.0, norm, 1.0), 0.0))

    @property
    def reduction(self) -> Floats:
        """Predicted reduction (k,) of the squared error, each direction alone."""
        return np.asarray(self.strength * self.after[:-1, -1])

    def reduction_at(self, j: int, strength: float) -> float:
        """The same for direction ``j`` at another strength."""
        return float(strength * (2.0 * self.after[j, -1] - strength * self.after[j, j]))

    @property
    def visibility(self) -> Floats:
        """(k,) share of a direction that the free parameters do not mask."""
        before = np.diag(self.before)[:-1]
        return np.asarray(np.where(before > 0.0, np.diag(self.after)[:-1] / np.where(before > 0.0, before, 1.0), 0.0))

    @property
    def collinearity(self) -> Floats:
        """|ρ| (k, k) between the projected directions."""
        norm = np.sqrt(np.diag(self.after)[:-1])
        scale = np.where(norm > 0.0, norm, np.inf)
        return np.asarray(np.abs(self.after[:-1, :-1]) / np.outer(scale, scale))


def project(gram: Floats, free: int) -> Projection:
    """Project the first ``free`` columns out of the others; ``gram`` (free + k + 1,)² are all inner products."""
    norm = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    scaled = gram / np.outer(norm, norm)
    values, vectors = np.linalg.eigh(scaled[:free, :free])
    keep = values > RANK * (values[-1] if free else 1.0)
    basis = vectors[:, keep] / np.sqrt(values[keep])
    coefficients = basis @ (basis.T @ scaled[:free, free:])
    after = scaled[free:, free:] - scaled[free:, :free] @ coefficients
    # What is left of a direction after rounding is nothing.
    diagonal = np.diag(after)
    after = np.where(np.outer(diagonal > 1e-9, diagonal > 1e-9), after, 0.0)
    rescale = np.outer(norm[free:], norm[free:])
    solve = coefficients * norm[free:] / norm[:free, None]
    return Projection(solve, gram[free:, free:], after * rescale)


def p_value(evidence: float, one_sided: bool, directions: int) -> float:
    """Of the largest evidence over ``directions`` values of a second parameter (Bonferroni), one-sided: half of χ²."""
    p = float(chi2.sf(evidence, 1)) * (0.5 if one_sided else 1.0)
    return min(1.0, directions * p)
