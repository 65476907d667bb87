# SPDX-License-Identifier: Apache-2.0
"""An unknown function of one covariate at one place of the model: a curve through knots (:mod:`lce_model.closures`)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.problem import Problem
from lce_model.closures import Place, closure
from lce_model.closures.covariates import NUMBER, Covariate
from lce_model.closures.forms import KNOTS

Floats = NDArray[np.float64]

TAILS: Final = 0.002
"""Share of the samples on either side that lie beyond the ends of the curve."""
FEW_VALUES: Final = frozenset({"branch", "cycle", "power"})
"""Covariates with few values, none of which is a tail."""


@dataclass(frozen=True)
class Candidate:
    """An unknown function at one place of the model, of one covariate between two ends; its reference is z0."""

    place: Place
    covariate: Covariate
    tau_s: float | None
    lower: float
    upper: float
    reference: float = 0.0

    @property
    def knots(self) -> Floats:
        """(KNOTS,) values of the covariate."""
        return np.linspace(self.lower, self.upper, KNOTS)

    @property
    def term(self) -> str:
        """Name of the closure's term."""
        return closure(self.place.name).name

    @property
    def settings(self) -> dict[str, float]:
        """TERM.PARAM to value: of which covariate, between which ends, at strength 1; the curve is still zero."""
        found = {
            "strength": 1.0,
            "covariate": NUMBER[self.covariate.name],
            "lower": self.lower,
            "upper": self.upper,
            "z0": self.reference,
            **({} if self.tau_s is None else {"tau": self.tau_s}),
        }
        return {f"{self.term}.{name}": float(x) for name, x in found.items()}

    @property
    def label(self) -> str:
        """Place and covariate, as progress bars and tables show them."""
        lag = "" if self.tau_s is None else f", {self.tau_s:g} s"
        return f"{self.place.name} × {self.covariate.name}{lag}"

    @property
    def strength(self) -> str:
        """TERM.PARAM of the factor of the whole function."""
        return f"{self.term}.strength"

    @property
    def weights(self) -> list[str]:
        """TERM.PARAM of the curve's values at its knots."""
        return [f"{self.term}.w_{k + 1}" for k in range(KNOTS)]


def ends(covariate: str, values: Floats) -> tuple[float, float] | None:
    """Where a curve over the values of a covariate begins and ends; None if it does not change."""
    tails = 0.0 if covariate in FEW_VALUES else TAILS
    lower, upper = (float(x) for x in np.quantile(values, [tails, 1.0 - tails]))
    return (lower, upper) if upper - lower > 1e-9 * max(abs(lower), abs(upper)) else None


def directions(problem: Problem, candidate: Candidate, here: Floats) -> Floats:
    """(KNOTS, N) change of the weighted outputs per unit of each weight; ``here`` (N,) are those of the model."""
    step = closure(candidate.place.name).parameter("w_1").knee
    model = problem.model.set(candidate.settings)
    rows = [model.set({key: model[key] + step}).vector for key in candidate.weights]
    slopes = (problem.response(np.array(rows)) - here) / step
    return np.where(np.isfinite(slopes), slopes, 0.0)


def with_curve(problem: Problem, candidate: Candidate, weights: Sequence[float], room: Sequence[float]) -> Problem:
    """The problem with a curve whose knots are free: where each begins, and how far it may move."""
    model = problem.model.set({**candidate.settings, **dict(zip(candidate.weights, weights, strict=True))})
    held = zip(candidate.weights, weights, room, strict=True)
    model = model.hold({key: (w - r, w + r) for key, w, r in held})
    free = tuple(sorted({*problem.free, *(model.index(key) for key in candidate.weights)}))
    return replace(problem, model=model, free=free)
