# SPDX-License-Identifier: Apache-2.0
"""Does a parameter differ from run to run? Tried and judged like an effect, for every parameter of the base model.

What it would take is read off the Jacobian: the column of a parameter, cut into one for each run. Where all of them
together do not promise most of the error, none is tried. The few that promise most are refitted as random effects.
Since no other run can say what a run's own value is, blocks within every run are left out in turn, and judged with the
value that the rest of the run gives.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from lce_analysis.diagnosis.held_out import DataLeftOut, HeldOut
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, mean_squares, refit, samples
from lce_analysis.diagnosis.misfit import NOISE, reduction_of
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.diagnosis.trial import Objection, on_data_left_out
from lce_analysis.identification.by_run import ByRun, may_vary
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem, start_conditions
from lce_analysis.identification.random_effects import heterogeneity
from lce_analysis.options import DiagnoseOptions
from lce_analysis.prediction import AMBIENT_KEY, with_ambient_at_rest
from lce_data.progress import Progress
from lce_model import Variation

Floats = NDArray[np.float64]

REFITTED: Final = 3
"""Parameters that are refitted in each step, those that promise most."""


@dataclass(frozen=True)
class VariationTrial:
    """A parameter refitted with a value for each run.

    predicted_reduction : share of the error above the noise that the Jacobian promised.
    gain : of the squared error, in units of the noise.
    fit : the refit, in whose model the parameter varies.
    held_out : errors on blocks of every run, left out in turn; None if the trial ended before.
    objection : why it is not worth having, "" if nothing speaks against it.
    """

    stage: StageProblem
    key: str
    predicted_reduction: float
    fit: LinearizedFit
    gain: float
    held_out: HeldOut | None = None
    objection: Objection = ""

    @property
    def reduction(self) -> float:
        """Share of the error above the noise that went in the refit, all sensors with the same weight."""
        return reduction_of(self.stage.fit.mean_squares, self.fit.mean_squares)


def variation_trial(
    stage: StageProblem, left_out: DataLeftOut, options: DiagnoseOptions, progress: Progress
) -> VariationTrial | None:
    """The parameter of a stage that takes most if it differs from run to run, of those against which nothing speaks.

    One that frees nothing comes first: ambient temperatures of the runs in the place of their start temperatures.
    """
    keys = _promising(stage, options)
    trials = each([partial(_refitted, stage, key, share, options) for key, share in keys], "refits", progress)
    ranked = sorted(trials, key=lambda t: (t.fit.independent > stage.fit.independent, -t.gain))
    judged = (_judged(trial, left_out, options) for trial in ranked)
    return next((trial for trial in judged if not trial.objection), None)


def _promising(stage: StageProblem, options: DiagnoseOptions) -> list[tuple[str, float]]:
    """The few parameters that promise most, and a share of what is above the noise; each has to promise a fair one."""
    problem = stage.fit.problem
    if len(problem.inputs) < 2:
        return []
    by_run = ByRun(problem, stage.fit.jacobian, stage.fit.residual)
    if not (problem.varying or _explain_together(stage, by_run, options)):
        return []
    counts = samples(problem.observed).values()
    beyond_noise = stage.fit.error - NOISE * sum(counts)
    least = max(options.promise * options.worth_noise * min(counts), options.far * beyond_noise)
    promised = {key: by_run.gain(key)[0] for key in by_run.keys}
    ranked = sorted(promised.items(), key=lambda item: -item[1])
    few = [key for key, gain in ranked if gain > least][:REFITTED]
    left = {key: mean_squares(by_run.rest([key]), problem.observed) for key in few}
    return [(key, reduction_of(stage.fit.mean_squares, left[key])) for key in few]


def _explain_together(stage: StageProblem, by_run: ByRun, options: DiagnoseOptions) -> bool:
    """Do all parameters, each with a value for each run, promise most of the error of a sensor?

    If not, what differs explains nothing, as the search would say in the end.
    """
    fit, rest = stage.fit, by_run.rest(by_run.keys)
    return any(
        fit.mean_squares[channel] - left >= options.most * max(fit.mean_squares[channel] - NOISE, 0.0)
        for channel, left in mean_squares(rest, fit.problem.observed).items()
    )


def _refitted(
    stage: StageProblem, key: str, predicted: float, options: DiagnoseOptions, progress: Progress
) -> VariationTrial:
    problem = with_variation(stage.fit.problem, key)
    fit = refit(problem, f"with {key} of each run", progress, options.iterations)
    return VariationTrial(stage, key, predicted, fit, stage.fit.error - fit.error)


def with_variation(problem: Problem, key: str) -> Problem:
    """The problem in which a parameter has a value for each run.

    Where it is the ambient temperature, a run that begins at rest begins at its own.
    """
    model = problem.model.varying({**problem.model.varies, key: Variation()})
    varying = replace(problem, model=model, free=tuple(sorted({*problem.free, model.index(key)})))
    if key != AMBIENT_KEY:
        return varying
    model = with_ambient_at_rest(model, [p.run for p in problem.inputs])
    free_starts, at_ambient = start_conditions(problem.inputs, model)
    return replace(varying, model=model, free_starts=free_starts, at_ambient=at_ambient)


def _judged(trial: VariationTrial, left_out: DataLeftOut, options: DiagnoseOptions) -> VariationTrial:
    found = _objection(trial, options)
    if found:
        return replace(trial, objection=found)
    errors = left_out.errors(trial.stage, trial.fit.problem, f"{trial.key} of each run")
    trial = replace(trial, held_out=errors)
    return replace(trial, objection=on_data_left_out(trial.stage, errors, options))


def _objection(trial: VariationTrial, options: DiagnoseOptions) -> Objection:
    """What speaks against it before anything is left out: no gain, or values alike as far as their errors can tell."""
    if trial.gain <= 0.0:
        return "null"
    runs, candidates = len(trial.fit.problem.inputs), max(len(may_vary(trial.stage.fit.problem)), 1)
    critical = float(chi2.isf(options.false_alarm / candidates, runs - 1))
    return "" if heterogeneity(trial.fit.problem, trial.key) > critical else "chance"
