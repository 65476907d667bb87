# SPDX-License-Identifier: Apache-2.0
"""A model at its least squares, and what it is worth in the metric of the noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnose.score import project
from lce_analysis.diagnose.whitening import Noise, autoregressive
from lce_analysis.fit.least_squares import Progress, levenberg_marquardt
from lce_analysis.fit.problem import Block, Problem

Floats = NDArray[np.float64]

FAR: Final = 0.5
"""Of a variable, which spans its bounds in π."""


def in_noise(blocks: Sequence[Block], noise: Mapping[int, Noise]) -> tuple[Block, ...]:
    """The blocks in units of their sensor's noise, not whitened."""
    return tuple(replace(b, weight=1.0 / noise[b.column].rms, whitening=np.ones(1)) for b in blocks)


def whitened(blocks: Sequence[Block], noise: Mapping[int, Noise]) -> tuple[Block, ...]:
    """The blocks in units of the innovations of their sensor's noise."""
    return tuple(replace(b, weight=1.0 / noise[b.column].sigma, whitening=noise[b.column].whitening) for b in blocks)


def raw(blocks: Sequence[Block]) -> tuple[Block, ...]:
    """The blocks in the units of their sensors."""
    return tuple(replace(b, weight=1.0, whitening=np.ones(1)) for b in blocks)


def gram(table: Floats, blocks: Sequence[Block], runs: int) -> Floats:
    """Inner products (runs, m, m) of raw rows (m, N), weighted as the blocks say."""
    found = np.zeros((runs, table.shape[0], table.shape[0]))
    end = 0
    for b in blocks:
        begin, end = end, end + b.measured.size
        white = b.weighted(table[:, begin:end])
        found[b.run] += white @ white.T
    return found


def noise_of(residual: Floats, blocks: Sequence[Block]) -> dict[int, Noise]:
    """Noise of each sensor from a raw residual (N,)."""
    parts: dict[int, list[Floats]] = {}
    end = 0
    for b in blocks:
        begin, end = end, end + b.measured.size
        part = residual[begin:end]
        parts.setdefault(b.column, []).append(part if b.keep is None else part[b.keep > 0.0])
    return {column: autoregressive(members) for column, members in parts.items()}


@dataclass(frozen=True)
class Settled:
    """A problem at its least squares.

    table : (free + 1, N) raw Jacobian over the free variables and, last, residual (measured minus model).
    """

    problem: Problem
    table: Floats

    @property
    def free(self) -> int:
        """Number of free variables: parameters and start temperatures."""
        return len(self.problem.free) + len(self.problem.free_starts)

    def plain_error(self, noise: Mapping[int, Noise]) -> float:
        """Squared residual in units of the sensors' noise."""
        return float(gram(self.table[-1:], in_noise(self.problem.blocks, noise), self._runs).sum())

    def error(self, noise: Mapping[int, Noise]) -> float:
        """Squared whitened residual that the free variables, linearised, cannot lower any further."""
        return project(self._gram(noise).sum(axis=0), self.free).error

    def noise(self, start: Mapping[int, Noise]) -> dict[int, Noise]:
        """Noise of each sensor, from what the free variables leave."""
        solved = project(self._gram(start).sum(axis=0), self.free).solve[:, -1]
        return noise_of(self.table[-1] - solved @ self.table[:-1], self.problem.blocks)

    def held_out(self, noise: Mapping[int, Noise]) -> Floats:
        """Squared whitened error (runs,) of each run at the parameters that the others give.

        The parameters without a run are one Gauss–Newton step from those with it; the run is then simulated with them.
        A variable that the step would carry out of reach of the linearisation, as one at its bound, stays where it is.
        """
        white = replace(self.problem, blocks=whitened(self.problem.blocks, noise))
        products = self._gram(noise)
        total, variables = products.sum(axis=0), white.first()
        errors = np.zeros(self._runs)
        for i in range(self._runs):
            others = total - products[i]
            near = np.append(np.abs(project(others, self.free).solve[:, -1]) < FAR, True)
            step = project(others * np.outer(near, near), self.free).solve[:, -1]
            step[len(white.free) :] = 0.0  # the start temperature is the run's own
            residual = white.residuals_of(i, variables + np.clip(step, -FAR, FAR))
            errors[i] = float(residual @ residual)
        return errors

    @property
    def _runs(self) -> int:
        return len(self.problem.inputs)

    def _gram(self, noise: Mapping[int, Noise]) -> Floats:
        return gram(self.table, whitened(self.problem.blocks, noise), self._runs)


def settle(problem: Problem, noise: Mapping[int, Noise], label: str, progress: Progress, iterations: int) -> Settled:
    """The problem at its plain least squares, each sensor in units of its noise; KeyboardInterrupt passes through.

    Not whitened: where much is still missing, the filter would hide all that is slow, and the search lose its way.
    """
    problem = replace(problem, blocks=in_noise(problem.blocks, noise))
    optimum = levenberg_marquardt(problem, problem.first(), label, progress, iterations, tolerance=1e-6)
    if optimum.interrupted:
        raise KeyboardInterrupt
    return linearised(problem.at(optimum.variables))


def linearised(problem: Problem) -> Settled:
    """The problem where it stands, with its Jacobian."""
    bare = replace(problem, blocks=raw(problem.blocks))
    variables = bare.first()
    return Settled(problem, np.vstack([bare.jacobian(variables).T, -bare.residuals(variables)]))
