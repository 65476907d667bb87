# SPDX-License-Identifier: Apache-2.0
"""A model at its least squares, and what it is worth in the metric of the noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.projection import project
from lce_analysis.diagnosis.whitening import Noise, autoregressive
from lce_analysis.identification.least_squares import levenberg_marquardt
from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_data.channels import Channel
from lce_data.progress import Progress

Floats = NDArray[np.float64]

MAX_STEP: Final = 0.5
"""Longest step of a search variable over which a linearisation holds: a sixth of its bounds, which it spans in π. A
number of the method, not a choice."""


def in_noise(observed: Sequence[ObservedSeries], noise: Mapping[Channel, Noise]) -> tuple[ObservedSeries, ...]:
    """The series in units of their sensor's noise, not whitened."""
    return tuple(replace(series, weight=1.0 / noise[series.channel].rms, whitening=np.ones(1)) for series in observed)


def whitened(observed: Sequence[ObservedSeries], noise: Mapping[Channel, Noise]) -> tuple[ObservedSeries, ...]:
    """The series in units of the innovations of their sensor's noise."""
    return tuple(
        replace(series, weight=1.0 / noise[series.channel].sigma, whitening=noise[series.channel].whitening)
        for series in observed
    )


def raw(observed: Sequence[ObservedSeries]) -> tuple[ObservedSeries, ...]:
    """The series in the SI units of their sensors."""
    return tuple(replace(series, weight=1.0, whitening=np.ones(1)) for series in observed)


def gram(table: Floats, observed: Sequence[ObservedSeries], runs: int) -> Floats:
    """Inner products (runs, m, m) of raw rows (m, N), weighted by the weights and filters of the series."""
    found = np.zeros((runs, table.shape[0], table.shape[0]))
    end = 0
    for series in observed:
        begin, end = end, end + series.measured.size
        white = series.weighted(table[:, begin:end])
        found[series.run] += white @ white.T
    return found


def noise_of(residual: Floats, observed: Sequence[ObservedSeries]) -> dict[Channel, Noise]:
    """Noise of each sensor from a raw residual (N,)."""
    parts: dict[Channel, list[Floats]] = {}
    end = 0
    for series in observed:
        begin, end = end, end + series.measured.size
        part = residual[begin:end]
        parts.setdefault(series.channel, []).append(part if series.keep is None else part[series.keep > 0.0])
    return {channel: autoregressive(members) for channel, members in parts.items()}


@dataclass(frozen=True)
class LinearizedFit:
    """A problem at its least squares.

    table : (free + 1, N) raw Jacobian over the free variables and, last, residual (measured minus model).
    """

    problem: Problem
    table: Floats

    @property
    def free(self) -> int:
        """Number of free variables: parameters and start temperatures."""
        return len(self.problem.free) + len(self.problem.free_starts)

    def plain_error(self, noise: Mapping[Channel, Noise]) -> float:
        """Squared residual in units of the sensors' noise."""
        return float(gram(self.table[-1:], in_noise(self.problem.observed, noise), self._runs).sum())

    def error(self, noise: Mapping[Channel, Noise]) -> float:
        """Squared whitened residual that the free variables, linearised, cannot lower any further."""
        return project(self._gram(noise).sum(axis=0), self.free).error

    def noise(self, start: Mapping[Channel, Noise]) -> dict[Channel, Noise]:
        """Noise of each sensor, from what the free variables leave."""
        solved = project(self._gram(start).sum(axis=0), self.free).solve[:, -1]
        return noise_of(self.table[-1] - solved @ self.table[:-1], self.problem.observed)

    def held_out(self, noise: Mapping[Channel, Noise]) -> Floats:
        """Squared whitened error (runs,) of each run at the parameters that the other runs give.

        The parameters without a run are one Gauss–Newton step from those with it; the run is then simulated with them.
        Two kinds of variables are frozen in that step: those that it would carry out of reach of the linearisation, as
        one at its bound, and the start temperatures, which belong to the run itself.
        """
        white = replace(self.problem, observed=whitened(self.problem.observed, noise))
        products = self._gram(noise)
        total, variables = products.sum(axis=0), white.first()
        errors = np.zeros(self._runs)
        for i in range(self._runs):
            step = self._gauss_newton_step(total - products[i])
            step[len(white.free) :] = 0.0
            residual = white.residuals_of(i, variables + np.clip(step, -MAX_STEP, MAX_STEP))
            errors[i] = float(residual @ residual)
        return errors

    def _gauss_newton_step(self, products: Floats) -> Floats:
        """From here to the least squares of some runs (free,), the variables frozen that would go too far.

        ``products`` (free + 1,)² are the inner products of those runs.
        """
        within_reach = np.append(np.abs(project(products, self.free).solve[:, -1]) < MAX_STEP, True)
        return np.array(project(products * np.outer(within_reach, within_reach), self.free).solve[:, -1])

    @property
    def _runs(self) -> int:
        return len(self.problem.inputs)

    def _gram(self, noise: Mapping[Channel, Noise]) -> Floats:
        return gram(self.table, whitened(self.problem.observed, noise), self._runs)


def refit(
    problem: Problem, noise: Mapping[Channel, Noise], label: str, progress: Progress, iterations: int
) -> LinearizedFit:
    """The problem at its plain least squares, each sensor in units of its noise; KeyboardInterrupt passes through.

    Not whitened: where much is still missing, the filter would hide all that is slow, and the search lose its way.
    """
    problem = replace(problem, observed=in_noise(problem.observed, noise))
    optimum = levenberg_marquardt(problem, problem.first(), label, progress, iterations, tolerance=1e-6)
    if optimum.interrupted:
        raise KeyboardInterrupt
    return linearised(problem.at(optimum.variables))


def linearised(problem: Problem) -> LinearizedFit:
    """The problem where it stands, with its Jacobian."""
    bare = replace(problem, observed=raw(problem.observed))
    variables = bare.first()
    return LinearizedFit(problem, np.vstack([bare.jacobian(variables).T, -bare.residuals(variables)]))
