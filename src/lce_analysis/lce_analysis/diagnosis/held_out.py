# SPDX-License-Identifier: Apache-2.0
"""What an effect is worth on data that it was not fitted to.

Runs held out by the user decide, if they show what the stage ends in. Without such runs, each run is left out in turn,
and the model is refitted to the others.
Where a single run shows what is judged, and where something differs from run to run, blocks of every run are left out:
what a run has of its own only the rest of that run can tell. An effect beside which something differs has to help on
the runs held out as well, each of which then has a value of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import mean_squares, optimum, samples, without_run
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, Pair
from lce_analysis.diagnosis.stage_problem import Data, StageProblem
from lce_analysis.identification.problem import ObservedSeries, Problem, start_conditions
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.prediction import MECHANICAL, model_of_run, simulation_input, start_temperature
from lce_data.channels import Channel
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model
from lce_model.terms import Term

Floats = NDArray[np.float64]
LeftOut = Literal["test runs", "each run in turn", "each block in turn"]

BLOCKS: Final = 5
"""Blocks into which a run is divided."""
ITERATIONS: Final = 15
TOLERANCE: Final = 1e-4
"""Of the refits without a run: they begin at the optimum of all runs, close to their own."""


@dataclass(frozen=True)
class HeldOut:
    """Errors of data left out.

    how : what was left out.
    names : of the runs, or of the blocks.
    errors : without and with the effect.
    """

    how: LeftOut
    names: tuple[str, ...]
    errors: Pair

    @property
    def before(self) -> Misfit:
        """Without the effect, on every sample; of blocks, away from jumps."""
        return self.errors.before

    @property
    def after(self) -> Misfit:
        """With the effect, on every sample; of blocks, away from jumps."""
        return self.errors.after


class DataLeftOut:
    """What is left out of the fits of a stage to judge them; the refits without an effect are made once."""

    def __init__(self, judged: JudgedRuns, tests: JudgedRuns, progress: Progress) -> None:
        self.judged, self.tests, self.progress = judged, tests, progress
        self._refits: dict[tuple[int, LeftOut], tuple[Problem, Sequence[Problem]]] = {}

    def how(self, stage: StageProblem, problem: Problem) -> LeftOut:
        """What is left out to judge a problem of a stage."""
        tested = self._tested(stage)
        showing = {series.run for series in stage.fit.problem.observed if series.channel in _ends(stage)}
        if problem.model.varies or (len(showing) < 2 and not tested):
            return "each block in turn"
        return "test runs" if tested else "each run in turn"

    def _tested(self, stage: StageProblem) -> bool:
        """Do the runs held out show what a stage ends in?"""
        return _ends(stage) <= {channel for run in self.tests.runs for channel in predicted(run)}

    def _showing(self, stage: StageProblem) -> list[int]:
        """The runs held out that show a sensor of a stage, by their numbers."""
        channels = set(stage.channels)
        return [i for i, run in enumerate(self.tests.runs) if channels & set(predicted(run))]

    def _names(self, how: LeftOut, stage: StageProblem) -> tuple[str, ...]:
        """Of the runs or blocks left out to judge a stage."""
        return tuple(self.tests.runs[i].name for i in self._showing(stage)) if how == "test runs" else self._parts(how)

    def _parts(self, how: LeftOut) -> tuple[str, ...]:
        """Of the runs, or of the blocks of every run."""
        if how == "each block in turn":
            one = f"{self.judged.runs[0].name}, " if len(self.judged.runs) == 1 else ""
            return tuple(f"{one}block {b + 1} of {BLOCKS}" for b in range(BLOCKS))
        return tuple(run.name for run in self.judged.runs)

    def errors(self, stage: StageProblem, with_it: Problem, effect: str) -> HeldOut:
        """Errors of a stage without and with an effect, refitted without what is left out."""
        without, how = stage.fit.problem, self.how(stage, with_it)
        if how == "test runs":
            errors = self.tests.pair(without.model, with_it.model, stage.drive, stage.channels)
        elif how == "each run in turn":
            errors = self._runs(stage, with_it, effect)
        else:
            before = _errors_of_blocks(without, self._refitted(without, how, "as it is"))
            after = _errors_of_blocks(with_it, self._refitted(with_it, how, f"with {effect}"))
            errors = Pair(before, after, before, after)
        return HeldOut(how, self._names(how, stage), errors)

    def on_test_runs(self, stage: StageProblem, without: Model, with_it: Model) -> HeldOut | None:
        """Errors of two models on the runs held out, where something differs from run to run; else None.

        What differs takes, in both models, the value that explains a run best: it is not what is judged.
        """
        if not with_it.varies or not self._tested(stage):
            return None
        pairs = []
        for one in map(self.tests.only, self._showing(stage)):
            first, second = (self._own_values(model, one, stage) for model in (without, with_it))
            pairs.append(one.pair(first, second, stage.drive, stage.channels))
        return HeldOut("test runs", self._names("test runs", stage), sum(pairs[1:], pairs[0]))

    def _own_values(self, model: Model, one: JudgedRuns, stage: StageProblem) -> Model:
        """The model with what differs from run to run, as far as the stage shows it, fitted to one run."""
        (run,) = one.runs
        shown = {t.name for t in model.terms if _shows(stage, t)}
        free = tuple(model.index(key) for key in model.varies if model.values[model.index(key)].term in shown)
        model = model_of_run(model, run).varying({})
        if not free:
            return model
        data = Data(one, (simulation_input(run, model),))
        starts = np.array([start_temperature(data.inputs[0], model)])
        if stage.drive == "measured":
            data = data.driven_by_measurement(model, starts)
        conditions = start_conditions(data.inputs, model)
        problem = Problem(model, data.inputs, free, starts, data.observed(stage.channels), *conditions)
        return optimum(problem, f"what {run.name} has of its own", self.progress, ITERATIONS, TOLERANCE).model

    def _runs(self, stage: StageProblem, with_it: Problem, effect: str) -> Pair:
        first = self._refitted(stage.fit.problem, "each run in turn", "as it is")
        second = self._refitted(with_it, "each run in turn", f"with {effect}")
        pairs = [
            self.judged.only(i).pair(a.model, b.model, stage.drive, stage.channels)
            for i, (a, b) in enumerate(zip(first, second, strict=True))
        ]
        return sum(pairs[1:], pairs[0])

    def _refitted(self, problem: Problem, how: LeftOut, label: str) -> Sequence[Problem]:
        """The problem refitted without each run, or each block, in turn."""
        known = self._refits.get((id(problem), how))
        if known is not None:
            return known[1]
        if how == "each run in turn":
            parts = [without_run(problem, i) for i in range(len(self.judged.runs))]
        else:
            parts = [_counting(problem, [1.0 - mask for mask in inside]) for inside in _blocks(problem)]
        found = [
            optimum(part, f"{label} without {name}", self.progress, ITERATIONS, TOLERANCE)
            for part, name in zip(parts, self._parts(how), strict=True)
        ]
        # The problem is kept beside its refits, so that its id stays its own.
        self._refits[id(problem), how] = problem, found
        return found


def predicted(run: Run) -> tuple[Channel, ...]:
    """The sensors of a run that a model can be compared with: without the laser power it says nothing of the heat."""
    return tuple(c for c in run.measured if c in MECHANICAL or run.power is not None)


def _ends(stage: StageProblem) -> set[Channel]:
    """The sensors that a stage ends in: those of the deformation, or else the temperature."""
    return {c for c in stage.channels if c in MECHANICAL} or set(stage.channels)


def _shows(stage: StageProblem, term: Term) -> bool:
    """Does what a stage is judged by depend on a term of the model?"""
    if stage.part == "heat":
        return acts_on_temperature(term)
    return stage.drive == "model" or not acts_on_temperature(term)


def _errors_of_blocks(problem: Problem, refits: Sequence[Problem]) -> Misfit:
    """Error of each block at the parameters that the others give."""
    total: dict[Channel, list[float]] = {}
    counts: dict[Channel, list[float]] = {}
    for inside, refitted in zip(_blocks(problem), refits, strict=True):
        block = _counting(replace(refitted, observed=problem.observed), inside)
        squares: Mapping[Channel, float] = mean_squares(block.residuals(block.first()), block.observed)
        for channel, size in samples(block.observed).items():
            total.setdefault(channel, []).append(squares[channel] * size)
            counts.setdefault(channel, []).append(size)
    return Misfit({c: np.array(x) for c, x in total.items()}, {c: np.array(x) for c, x in counts.items()})


def _blocks(problem: Problem) -> list[list[Floats]]:
    """For each block and series: 1 for the samples (n,) inside, else 0. Every run is divided for itself."""
    return [[_inside(problem, series, b) for series in problem.observed] for b in range(BLOCKS)]


def _inside(problem: Problem, series: ObservedSeries, block: int) -> Floats:
    grid = problem.inputs[series.run].time_s
    time = series.sampling(grid)
    at = np.minimum((time / grid[-1] * BLOCKS).astype(np.intp), BLOCKS - 1)
    return np.where(at == block, 1.0, 0.0)


def _counting(problem: Problem, keep: Sequence[Floats]) -> Problem:
    """The problem of some samples only, of those that count at all."""
    observed = [
        replace(s, keep=mask if s.keep is None else mask * s.keep)
        for s, mask in zip(problem.observed, keep, strict=True)
    ]
    return replace(problem, observed=tuple(observed))
