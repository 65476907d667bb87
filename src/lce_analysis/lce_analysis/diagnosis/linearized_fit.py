# SPDX-License-Identifier: Apache-2.0
"""A model at its least squares, with its Jacobian."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.at_bounds import AT
from lce_analysis.identification.least_squares import SLOW
from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_analysis.identification.random_effects import settle
from lce_data.channels import Channel
from lce_data.progress import Progress

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LinearizedFit:
    """A problem at its least squares, in units of the sensors' noise.

    jacobian : (N, free) over the free variables.
    residual : (N,) model minus measured.
    """

    problem: Problem
    jacobian: Floats
    residual: Floats

    @property
    def free(self) -> int:
        """Number of free variables: parameters, what they differ by in each run, and start temperatures."""
        return len(self.problem.free) + self.problem.offsets + len(self.problem.free_starts)

    @property
    def independent(self) -> int:
        """The same, where the values of the runs and the value of all count once."""
        return self.free - len(self.problem.varying)

    @cached_property
    def movable(self) -> Floats:
        """The Jacobian, 0 in the column of a parameter that would leave its bounds if it lowered the error further."""
        k = len(self.problem.free)
        place = self.problem.transformation.to_box(self.problem.model.vector[list(self.problem.free)])
        downhill = -(self.residual @ self.jacobian[:, :k])
        held = ((place >= 1.0 - AT) & (downhill > 0.0)) | ((place <= AT) & (downhill < 0.0))
        found = self.jacobian.copy()
        found[:, :k][:, held] = 0.0
        return found

    @property
    def error(self) -> float:
        """Squared residual."""
        return float(self.residual @ self.residual)

    @cached_property
    def mean_squares(self) -> dict[Channel, float]:
        """Mean squared residual of each channel; 1 is nothing but noise."""
        return mean_squares(self.residual, self.problem.observed)


def spans(observed: Sequence[ObservedSeries]) -> list[tuple[int, int]]:
    """Where each series begins and ends in the residual."""
    ends = np.cumsum([0, *(series.size for series in observed)]).tolist()
    return list(pairwise(ends))


def samples(observed: Sequence[ObservedSeries]) -> dict[Channel, float]:
    """How many samples of each channel count."""
    counts: dict[Channel, float] = {}
    for series in observed:
        counts[series.channel] = counts.get(series.channel, 0.0) + series.counted
    return counts


def mean_squares(residual: Floats, observed: Sequence[ObservedSeries]) -> dict[Channel, float]:
    """Mean square of a residual (N,) by channel; 1 is nothing but noise."""
    totals: dict[Channel, float] = {}
    for (begin, end), series in zip(spans(observed), observed, strict=True):
        part = residual[begin:end]
        totals[series.channel] = totals.get(series.channel, 0.0) + float(part @ part)
    counts = samples(observed)
    return {channel: total / max(counts[channel], 1.0) for channel, total in totals.items()}


def gained(before: LinearizedFit, after: LinearizedFit) -> float:
    """Squared error that went, of the sensors by which the first fit is judged; the second may be judged by more."""
    counts = samples(before.problem.observed)
    return sum((x - after.mean_squares[c]) * counts[c] for c, x in before.mean_squares.items())


def refit(problem: Problem, label: str, progress: Progress, iterations: int, tolerance: float = 1e-6) -> LinearizedFit:
    """The problem at its least squares, bounds in force; KeyboardInterrupt passes through."""
    return linearised(optimum(problem, label, progress, iterations, tolerance))


def optimum(problem: Problem, label: str, progress: Progress, iterations: int, tolerance: float = 1e-6) -> Problem:
    """The same, without its Jacobian."""
    found, search = settle(problem, label, progress, iterations, tolerance, SLOW)
    if search.interrupted:
        raise KeyboardInterrupt
    return found


def linearised(problem: Problem) -> LinearizedFit:
    """The problem where it stands, with its Jacobian."""
    variables = problem.first()
    residuals = problem.residuals(variables)
    return LinearizedFit(problem, problem.jacobian(variables, residuals=residuals), residuals)


def error_as_it_stands(problem: Problem) -> float:
    """Of a problem as it stands, in units of the noise; infinite where it cannot be simulated."""
    residual = problem.residuals(problem.first())
    return float(np.nan_to_num(residual @ residual, nan=np.inf))


def without_run(problem: Problem, i: int) -> Problem:
    """The problem of all runs but one."""
    kept = [k for k in range(len(problem.inputs)) if k != i]
    place = {k: n for n, k in enumerate(kept)}
    return replace(
        problem,
        inputs=[problem.inputs[k] for k in kept],
        starts_k=problem.starts_k[kept],
        observed=tuple(replace(s, run=place[s.run]) for s in problem.observed if s.run in place),
        free_starts=tuple(place[k] for k in problem.free_starts if k in place),
        at_ambient=tuple(place[k] for k in problem.at_ambient if k in place),
    )
