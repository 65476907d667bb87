# SPDX-License-Identifier: Apache-2.0
"""A curve as it can be drawn and told: what the data show of it, with its band, and what the model absorbs of it."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.discovery.closure import Closure
from lce_analysis.unknown_function import Candidate
from lce_data.units import KELVIN

Floats = NDArray[np.float64]

STEADY: Final = 0.7
"""A curve rises or falls if its ends differ by more than this share of its range."""


@dataclass(frozen=True)
class Curve:
    """The part of a function that the data show.

    x : (k,) covariate, within the data; y, error : (k,) value and standard error, in the unit of the place.
    offset, slope : does the model absorb a constant, or a straight line, of it?
    """

    candidate: Candidate
    x: Floats
    y: Floats
    error: Floats
    offset: bool
    slope: bool

    @property
    def words(self) -> str:
        """What is lacking where, how much at most, and how it goes on."""
        candidate, at = self.candidate, int(np.argmax(np.abs(self.y)))
        kind = _amount(candidate, self.y[at])
        lag = "" if candidate.tau_s is None else f" {candidate.tau_s:g} s"
        told = (
            f"{candidate.place.words} {'lacks' if self.y[at] > 0.0 else 'has too much by'} {kind} "
            f"{_where(candidate, self.x[at])}, {self._course} the {candidate.covariate.words}{lag}"
        )
        absorbed = [word for word, is_so in (("a constant", self.offset), ("a straight line", self.slope)) if is_so]
        return f"{told}; {' and '.join(absorbed)} may be added to it, as the model absorbs that" if absorbed else told

    @property
    def _course(self) -> str:
        change, extent = float(self.y[-1] - self.y[0]), float(np.ptp(self.y))
        if abs(change) < STEADY * extent:
            return "going up and down with"
        return "rising with" if change > 0.0 else "falling with"


def curve(closure: Closure) -> Curve:
    """The refitted curve at the knots that the data visited.

    What the model absorbs is chosen so that the curve begins with nothing: it is zero at the reference of the
    covariate, and where a straight line is absorbed too, flat in the half nearest to it.
    """
    candidate, moments = closure.candidate, closure.examined.moments
    own, weight = moments.visited, np.diag(moments.before)
    x = candidate.knots[own]
    offset = moments.absorbs(np.ones(candidate.knots.size))
    slope = moments.absorbs(candidate.knots - np.average(candidate.knots, weights=weight))
    gauge = np.eye(own.size)
    if offset:
        near = np.argsort(np.abs(x - candidate.reference), kind="stable")[: max(own.size // 2, 2) if slope else 1]
        line = np.column_stack([np.ones(own.size), x - candidate.reference])[:, : 2 if slope else 1]
        gauge[:, near] -= line @ np.linalg.pinv(line[near])
    y = gauge @ (moments.seen @ closure.weights)[own]
    covariance = gauge @ closure.examined.seen[1][np.ix_(own, own)] @ gauge.T
    return Curve(candidate, x, y, np.sqrt(np.maximum(np.diag(covariance), 0.0)), offset, slope)


def _amount(candidate: Candidate, value: float) -> str:
    """A value of the function as people say it."""
    unit = candidate.place.unit
    if unit == "1":
        return f"{abs(value):.2g} of itself"
    return f"{abs(value) * 1e6:.3g} µm" if unit == "m" else f"{abs(value):.3g} {unit}"


def _where(candidate: Candidate, value: float) -> str:
    """A value of the covariate as people say it."""
    covariate = candidate.covariate
    if covariate.name == "temperature":
        return f"at {value - KELVIN:.3g} °C"
    if covariate.name == "branch":
        return "while heating" if value > 0.0 else "while cooling"
    amount = f"{value * 1e3:.3g} mm" if covariate.unit == "m" else f"{value:.3g} {covariate.unit}".removesuffix(" 1")
    return f"where the {covariate.words} is {amount}"
