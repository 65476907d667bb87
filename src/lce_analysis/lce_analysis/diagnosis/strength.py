# SPDX-License-Identifier: Apache-2.0
"""One strength or as many as runs? The strength of an effect, from all runs and from each of them.

A true effect has one strength. What merely stands in for it needs another in every run. Both are read off the
linearisation at the optimum with the effect: all other parameters are shared by the runs and re-estimated together
with a strength for each run.

Where each of several parameters can do what the effect does, as the lag and the dead time of a camera, runs hardly tell
one from the other. The strength is then that of the one that does most, and the others stay as they are.

Standard errors are those of a sandwich estimator, clustered in time (Liang and Zeger 1986): residuals within a block
may be correlated in any way, and larger in some blocks than in others, as the misfit of an imperfect model is.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit
from lce_analysis.diagnosis.projection import RANK
from lce_model.effects import Effect

Floats = NDArray[np.float64]

BLOCK_S: Final = 10.0
"""Length of a block [s]: longer than the noise of any sensor is correlated."""
FEWEST: Final = 4
"""Blocks for each free variable, at least; in short runs they are shorter."""


@dataclass(frozen=True)
class Estimate:
    """A value and its standard error, in the same unit."""

    value: float
    standard_error: float


@dataclass(frozen=True)
class Strengths:
    """The strength of an effect beyond its null value.

    parameter : name of the parameter that is the strength here.
    overall : from all runs together.
    inflation : squared standard error over that which white noise of the sensors alone would give.
    samples_per_block : residuals that the standard errors take together; a constant one is inflated by so much.
    by_run : from each run; None where a run says nothing of it.
    """

    parameter: str
    overall: Estimate
    inflation: float
    samples_per_block: float
    by_run: tuple[Estimate | None, ...]

    @property
    def spread(self) -> float:
        """Standard deviation between runs beyond their standard errors (DerSimonian and Laird 1986)."""
        known = [e for e in self.by_run if e is not None]
        if len(known) < 2:
            return 0.0
        value = np.array([e.value for e in known])
        weight = np.array([e.standard_error**-2 for e in known])
        mean = float(np.sum(weight * value) / np.sum(weight))
        q = float(np.sum(weight * (value - mean) ** 2))
        scale = float(np.sum(weight) - np.sum(weight**2) / np.sum(weight))
        return math.sqrt(max(0.0, (q - (len(known) - 1)) / scale)) if scale > 0.0 else 0.0

    @property
    def mean(self) -> Estimate:
        """Mean over the runs, with the spread between them in its standard error."""
        known = [e for e in self.by_run if e is not None]
        if len(known) < 2:
            return self.overall
        spread = self.spread
        weight = np.array([1.0 / (e.standard_error**2 + spread**2) for e in known])
        value = np.array([e.value for e in known])
        return Estimate(float(np.sum(weight * value) / np.sum(weight)), float(np.sum(weight) ** -0.5))


def strengths_of(fit: LinearizedFit, effect: Effect) -> Strengths | None:
    """Strengths of an effect in a fit that stands at its optimum, of the parameter that does most of what it does.

    None if the strength is not free there: of an effect that acts back on the heat, where the heat is alone.
    """
    problem = fit.problem
    place = {problem.model.values[i].key: j for j, i in enumerate(problem.free)}
    if effect.strength_key not in place:
        return None
    amplitudes = {name: place[key] for name in effect.amplitudes if (key := f"{effect.name}.{name}") in place}

    def size(name: str) -> float:
        column = amplitudes[name]
        change = problem.model[f"{effect.name}.{name}"] - effect.parameter(name).default
        return float(np.linalg.norm(fit.jacobian[:, column])) * abs(change) / max(float(problem.slopes[column]), 1e-300)

    most = max(amplitudes, key=size)
    return strengths(fit, amplitudes[most], [column for name, column in amplitudes.items() if name != most])


def strengths(fit: LinearizedFit, column: int, held: Sequence[int] = ()) -> Strengths:
    """Strengths where the free variable ``column`` of a fit that stands at its optimum is one, and others are ``held``.

    They are in the unit of the parameter: the value at the optimum, and that plus what each run would change.
    """
    runs = len(fit.problem.inputs)
    blocks = _blocks(fit)
    own = fit.jacobian[:, column]
    others = np.delete(fit.movable, [column, *held], axis=1)
    position = fit.problem.free[column]
    value = float(fit.problem.model.vector[position])
    slope = float(fit.problem.slopes[column])
    run_of = np.concatenate([np.full(series.size, series.run) for series in fit.problem.observed])
    _, shared, inflation = _solve(np.column_stack([others, own]), fit.residual, blocks)
    apart = np.zeros((own.size, runs))
    apart[np.arange(own.size), run_of] = own
    step, errors, _ = _solve(np.column_stack([others, apart]), fit.residual, blocks)
    first = others.shape[1]
    found = [Estimate(value + slope * float(step[first + i]), slope * float(errors[first + i])) for i in range(runs)]
    by_run = tuple(e if np.isfinite(e.standard_error) and e.standard_error > 0.0 else None for e in found)
    overall = Estimate(value, slope * float(shared[-1]))
    name = fit.problem.model.values[position].parameter.name
    return Strengths(name, overall, float(inflation[-1]), own.size / np.unique(blocks).size, by_run)


def _blocks(fit: LinearizedFit) -> NDArray[np.intp]:
    """Number of the block (N,) of each sample: the same for all sensors of a run at the same time."""
    observed, numbers = fit.problem.observed, []
    spans_s = [float(i.time_s[-1] - i.time_s[0]) for i in fit.problem.inputs]
    length = min(BLOCK_S, sum(spans_s) / (FEWEST * max(fit.free, 1)))
    per_run = int(max(spans_s) // length) + 1
    for series in observed:
        time = fit.problem.inputs[series.run].time_s
        at = series.sampling(time - time[0])
        numbers.append(series.run * per_run + (at // length).astype(np.intp))
    return np.concatenate(numbers)


def _solve(columns: Floats, residual: Floats, blocks: NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
    """Step to the least squares (k,), clustered standard errors (k,; infinite where undetermined), their inflation."""
    gram = columns.T @ columns
    norm = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, vectors = np.linalg.eigh(gram / np.outer(norm, norm))
    keep = values > RANK * values[-1]
    inverse = (vectors[:, keep] / values[keep]) @ vectors[:, keep].T / np.outer(norm, norm)
    step = -inverse @ (columns.T @ residual)
    rest = residual + columns @ step
    count = int(blocks.max()) + 1
    scores = np.array([np.bincount(blocks, weights=columns[:, j] * rest, minlength=count) for j in range(norm.size)])
    used = np.unique(blocks).size
    meat = scores @ scores.T * used / max(used - int(keep.sum()), 1)
    variance = np.diag(inverse @ meat @ inverse)
    white = np.diag(inverse)
    determined = np.diag(gram) > 1e-12 * np.max(np.diag(gram))
    errors = np.where(determined, np.sqrt(np.maximum(variance, white)), np.inf)
    return step, errors, np.maximum(variance / np.maximum(white, 1e-300), 1.0)
