# SPDX-License-Identifier: Apache-2.0
"""What an effect is worth on data that it was not fitted to.

Runs held out by the user decide. Without any, each run is left out in turn, and the others are refitted without it and
with the effect; with a single run, blocks of it are left out.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, mean_squares, optimum, samples, without_run
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_data.progress import Progress

Floats = NDArray[np.float64]
LeftOut = Literal["test runs", "each run in turn", "each block in turn"]

BLOCKS: Final = 5
"""Blocks into which a single run is divided."""
ITERATIONS: Final = 15
TOLERANCE: Final = 1e-4
"""Of the refits without a run: they begin at the optimum of all runs, close to their own."""


@dataclass(frozen=True)
class HeldOut:
    """Errors of data left out.

    how : what was left out.
    names : of the runs, or of the blocks of one run.
    before, after : without and with the effect.
    """

    how: LeftOut
    names: tuple[str, ...]
    before: Misfit
    after: Misfit


def left_out(judged: JudgedRuns, tests: JudgedRuns) -> LeftOut:
    """What can be left out."""
    if tests.runs:
        return "test runs"
    return "each run in turn" if len(judged.runs) > 1 else "each block in turn"


def held_out_misfit(
    stage: StageProblem, fit: LinearizedFit, judged: JudgedRuns, tests: JudgedRuns, label: str, progress: Progress
) -> Misfit:
    """Errors of a fit of a stage on what is left out."""
    how = left_out(judged, tests)
    if how == "test runs":
        return tests.misfit(fit.problem.model, stage.drive, stage.channels)
    parts = (
        _each_run(stage, fit, judged, label, progress)
        if how == "each run in turn"
        else _each_block(fit, label, progress)
    )
    total = Misfit({}, {})
    for part in parts:
        total = total + part
    return total


def names_left_out(judged: JudgedRuns, tests: JudgedRuns) -> tuple[str, ...]:
    """Names of what is left out."""
    how = left_out(judged, tests)
    if how == "each block in turn":
        return tuple(f"{judged.runs[0].name}, block {b + 1} of {BLOCKS}" for b in range(BLOCKS))
    return tuple(run.name for run in (tests.runs if how == "test runs" else judged.runs))


def _each_run(
    stage: StageProblem, fit: LinearizedFit, judged: JudgedRuns, label: str, progress: Progress
) -> Iterator[Misfit]:
    for i, run in enumerate(judged.runs):
        found = optimum(without_run(fit.problem, i), f"{label} without {run.name}", progress, ITERATIONS, TOLERANCE)
        yield judged.only(i).misfit(found.model, stage.drive, stage.channels)


def _each_block(fit: LinearizedFit, label: str, progress: Progress) -> Iterator[Misfit]:
    problem = fit.problem
    last = max(float(p.time_s[-1]) for p in problem.inputs)
    for b in range(BLOCKS):
        inside = [_inside(problem, series, b * last / BLOCKS, (b + 1) * last / BLOCKS) for series in problem.observed]
        rest = _counting(problem, [1.0 - mask for mask in inside])
        found = optimum(rest, f"{label} without block {b + 1}", progress, ITERATIONS, TOLERANCE)
        block = _counting(found, inside)
        counts = samples(block.observed)
        squares = mean_squares(block.residuals(block.first()), block.observed)
        yield Misfit(
            {c: np.array([squares[c] * counts[c]]) for c in squares}, {c: np.array([counts[c]]) for c in squares}
        )


def _inside(problem: Problem, series: ObservedSeries, begin_s: float, end_s: float) -> Floats:
    """1 for the samples (n,) of a part of the run that count, else 0."""
    time = series.sampling(problem.inputs[series.run].time_s)
    inside = np.where((time >= begin_s) & (time < end_s), 1.0, 0.0)
    return inside if series.keep is None else inside * series.keep


def _counting(problem: Problem, keep: Sequence[Floats]) -> Problem:
    """The problem of some samples only, of those that count at all."""
    observed = [
        replace(s, keep=mask if s.keep is None else mask * s.keep)
        for s, mask in zip(problem.observed, keep, strict=True)
    ]
    return replace(problem, observed=tuple(observed))
