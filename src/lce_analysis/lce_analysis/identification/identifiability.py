# SPDX-License-Identifier: Apache-2.0
"""What the data say of the parameters: standard errors, correlations, and what they do not determine, in words."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lce_analysis.options import FitOptions

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Identifiability:
    """Uncertainty of k parameters in natural units: e-folds, or tenths of the bounds.

    Attributes
    ----------
    keys : (k,) names of the parameters, TERM.PARAM.
    directions : (k, k) columns are orthonormal combinations of the parameters, best determined first.
    spread : (k,) their standard deviations; infinite where the data say nothing.
    standard_errors : (k,) of the parameters, NaN where not determined.
    determined : (k,) whether a parameter itself is determined.
    correlation : (k, k).
    sentences : what is not determined, in words.
    strong_correlation : |ρ| above which two parameters are reported as strongly correlated.
    """

    keys: tuple[str, ...]
    directions: Floats
    spread: Floats
    standard_errors: Floats
    determined: NDArray[np.bool_]
    correlation: Floats
    sentences: tuple[str, ...]
    strong_correlation: float = FitOptions.strong_correlation

    def strong_correlations(self, threshold: float | None = None) -> list[tuple[str, str, float]]:
        """Pairs of determined parameters that the data hardly tell apart.

        Parameters
        ----------
        threshold : |ρ| above which a pair is reported, that of the fit (`FitOptions.strong_correlation`) if None.

        Returns
        -------
        list of (str, str, float)
            The names of the two, and their correlation ρ.
        """
        least = self.strong_correlation if threshold is None else threshold
        known = np.flatnonzero(self.determined).tolist()
        return [
            (self.keys[i], self.keys[j], float(self.correlation[i, j]))
            for i, j in itertools.combinations(known, 2)
            if abs(self.correlation[i, j]) > least
        ]


def identifiability(
    jacobian: Floats,
    keys: Sequence[str],
    logarithmic: NDArray[np.bool_],
    undetermined: float = FitOptions.undetermined,
    strong_correlation: float = FitOptions.strong_correlation,
) -> Identifiability:
    """From the Jacobian (N, k) of residuals with unit variance over parameters in natural units.

    Nuisance variables must have been projected out of the Jacobian; a column of zeros is a parameter without effect.
    A direction with a standard deviation above ``undetermined`` is not determined by the data.
    """
    _, singular, rows = np.linalg.svd(jacobian, full_matrices=False)
    with np.errstate(divide="ignore"):
        spread = np.where(singular > 1e-9 * max(float(singular[0]), 1e-300), 1.0 / singular, np.inf)
    directions = rows.T
    # An unlimited spread would make 0 · ∞ of parameters that have no part in it.
    finite = np.minimum(spread, 1e4)
    covariance = (directions * finite**2) @ directions.T
    errors = np.sqrt(np.diag(covariance))
    determined = errors <= undetermined
    correlation = covariance / np.outer(errors, errors)
    return Identifiability(
        keys=tuple(keys),
        directions=directions,
        spread=spread,
        standard_errors=np.where(determined, errors, np.nan),
        determined=np.asarray(determined, dtype=np.bool_),
        correlation=correlation,
        sentences=tuple(_in_words(v, keys, logarithmic) for v in _sparse(directions[:, spread > undetermined]).T),
        strong_correlation=strong_correlation,
    )


def _sparse(basis: Floats) -> Floats:
    """The same subspace (k, r), each vector with as few parameters as elimination with complete pivoting gives."""
    vectors = basis.T.copy()
    free_rows = list(range(vectors.shape[0]))
    while free_rows:
        r, c = max(((r, c) for r in free_rows for c in range(vectors.shape[1])), key=lambda rc: abs(vectors[rc]))
        vectors[r] /= vectors[r, c]
        for other in range(vectors.shape[0]):
            if other != r:
                vectors[other] -= vectors[other, c] * vectors[r]
        free_rows.remove(r)
    return vectors.T


def _in_words(vector: Floats, keys: Sequence[str], logarithmic: NDArray[np.bool_]) -> str:
    """A direction along which the fit does not change, as a sentence."""
    vector = vector / np.max(np.abs(vector))
    involved = [int(i) for i in np.argsort(-np.abs(vector)) if abs(vector[i]) > 0.1]
    names = [keys[i] for i in involved]
    if len(involved) == 1:
        return f"{names[0]} is not determined"
    if len(involved) == 2 and logarithmic[involved].all():
        i, j = involved
        if abs(vector[i] - vector[j]) < 0.1:
            return f"only the ratio {names[0]}/{names[1]} is determined"
        if abs(vector[i] + vector[j]) < 0.1:
            return f"only the product {names[0]}·{names[1]} is determined"
    changes = [f"{keys[i]} {_change(float(vector[i]), bool(logarithmic[i]))}" for i in involved]
    return f"these change together without a visible change of the fit: {', '.join(changes)}"


def _change(amount: float, logarithmic: bool) -> str:
    return f"×{np.exp(0.1 * amount):.3g}" if logarithmic else f"{0.1 * amount:+.2g} tenths of its bounds"
