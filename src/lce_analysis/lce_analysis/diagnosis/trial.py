# SPDX-License-Identifier: Apache-2.0
"""A candidate tried: the model refitted with it, beside the same model without it, and what speaks against it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from lce_analysis.diagnosis.held_out import HeldOut
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, error_as_it_stands
from lce_analysis.diagnosis.misfit import NOISE, Misfit, reduction_of, share_removed
from lce_analysis.diagnosis.score import Score
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.diagnosis.strength import Strengths
from lce_analysis.identification.problem import Problem
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.identification.transformation import Transformation
from lce_analysis.inputs import differs_between_runs_only
from lce_analysis.options import DiagnoseOptions
from lce_data.channels import TEMPERATURE, Channel
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect
from lce_model.terms import Parameter

Floats = NDArray[np.float64]
Objection = Literal[
    "", "null", "chance", "masked", "worse", "small", "varies", "less", "part", "resembles", "form", "bound",
    "long", "hidden", "driven", "disturbed", "base",
]  # fmt: skip

LONGEST_FIRST_STEP: Final = 0.3
"""Longest first step of a search variable, a tenth of its bounds. It and the lengths change how long a refit takes."""
STEP_LENGTHS: Final = (1.0, 0.4, 0.15, 0.05)
"""Shares of that step that are tried."""
AT_NULL: Final = 1e-3
"""A strength within this share of its range from its null value is at it."""


@dataclass(frozen=True)
class Trial:
    """A candidate refitted in a stage.

    score : what the score test said of it before.
    fit : the refit.
    gain : of the squared error, in units of the noise.
    strengths : from all runs, and from each.
    held_out : errors on data left out; None if the trial ended before.
    objection : why it is not worth having, "" if nothing speaks against it.
    """

    stage: StageProblem
    score: Score
    fit: LinearizedFit
    gain: float
    strengths: Strengths | None = None
    held_out: HeldOut | None = None
    objection: Objection = ""

    @property
    def effect(self) -> Effect:
        """Which effect."""
        return self.score.effect

    @property
    def amplitude(self) -> Parameter:
        """The parameter that does most of what the effect does: its strength, or one that acts alone."""
        return self.effect.parameter(self.strengths.parameter if self.strengths else self.effect.strength)

    @property
    def strength(self) -> float:
        """Its value."""
        return self.fit.problem.model[f"{self.effect.name}.{self.amplitude.name}"]

    @property
    def predicted_reduction(self) -> float:
        """Share of the error above the noise that the score test promised."""
        return self.score.predicted_reduction

    @property
    def reduction(self) -> float:
        """Share of the error above the noise that went in the refit, all sensors with the same weight."""
        return reduction_of(self.stage.fit.mean_squares, self.fit.mean_squares)


def untouched_by(effect: Effect) -> Channel | None:
    """The temperature, if the effect does nothing to it: a joint refit moves it a little, whatever the effect."""
    return None if acts_on_temperature(effect) else TEMPERATURE


def with_effect(problem: Problem, effect: Effect) -> Problem:
    """The problem with the parameters of the effect among the free ones."""
    extra = [i for i, v in enumerate(problem.model.values) if v.term == effect.name and not v.parameter.fixed]
    return replace(problem, free=tuple(sorted({*problem.free, *extra})))


def penalty(effect: Effect, library: int, false_alarm: float) -> float:
    """Reduction of the squared error (-2 ln L) that the effect must exceed: 2 n ln(n_library/p)."""
    freed = sum(not p.fixed for p in effect.parameters)
    return 2.0 * freed * math.log(library / false_alarm)


def first_step(stage: StageProblem, score: Score, solve: Floats) -> Problem:
    """The full model moved to the optimum of the linearisation, as far as that helps; one simulation a length.

    solve : (free, directions + 1) of the score test's projection.
    """
    base, null = stage.fit.problem, score.direction.amplitude.default
    z = base.first()
    strength = score.expected_strength - null
    shift = np.clip(solve[:, -1] - strength * solve[:, score.index], -LONGEST_FIRST_STEP, LONGEST_FIRST_STEP)
    best, least = base, math.inf
    for length in STEP_LENGTHS:
        there = base.at(z + length * shift)
        there = replace(there, model=there.model.set(score.direction.at(null + length * strength)))
        error = error_as_it_stands(there)
        if error < least:
            best, least = there, error
    return best


def effect_alone(stage: StageProblem, score: Score) -> Problem:
    """The full model with the effect at the strength that is expected of it, all else as it was.

    An effect that is measured at several strengths has no slope: it gets the one that leaves least. At an end of the
    camera's range where the model does not come, a refit would find no way.
    """
    base, effect = stage.fit.problem, score.effect

    def at(strength: float) -> Problem:
        return replace(base, model=base.model.set(score.direction.at(strength)))

    if len(effect.step_sizes) == 1 or score.direction.amplitude.name != effect.strength:
        return at(score.expected_strength)
    tried = sorted({effect.null, score.expected_strength, *(effect.null + size for size in effect.step_sizes)})
    errors = [error_as_it_stands(at(strength)) for strength in tried]
    # Of those that do nothing, the one next to where it begins to do something.
    k = max(i for i, error in enumerate(errors) if error == min(errors))
    bounds = tried[max(k - 1, 0)], tried[min(k + 1, len(tried) - 1)]
    between = minimize_scalar(lambda strength: error_as_it_stands(at(strength)), bounds=bounds, method="bounded")
    return at(float(between.x) if between.fun < errors[k] else tried[k])


def reach(trial: Trial, options: DiagnoseOptions) -> float:
    """The share of what is above the noise of a sensor that the effect takes, or promises."""
    before, after = trial.stage.fit.mean_squares, trial.fit.mean_squares
    beyond = [channel for channel, x in before.items() if x > NOISE + options.worth_noise]
    return max([trial.predicted_reduction, *(reduction_of({c: before[c]}, {c: after[c]}) for c in beyond)])


def goes_far(trial: Trial, options: DiagnoseOptions) -> bool:
    """Does the effect take, or promise, a fair share of what is above the noise of a sensor?

    The last effect of a part of the model has to take most of that. It promises a fair share already while others are
    missing beside it; so where no effect does, none of them can be the last. Where the measured temperature has to
    drive the deformation, one effect has to do most of it from the first: what several do together there is not told
    from what the drive does.
    """
    least = options.most if trial.stage.drive == "measured" else options.far
    return reach(trial, options) >= least


def objection(trial: Trial, library: int, options: DiagnoseOptions) -> Objection:
    """What speaks against the effect, the plainest first."""
    spec = trial.amplitude
    if trial.gain <= 0.0 or abs(trial.strength - spec.default) <= AT_NULL * (spec.upper - spec.lower):
        return "null"
    inflation = trial.strengths.inflation if trial.strengths else 1.0
    if trial.gain <= penalty(trial.effect, library, options.false_alarm) * inflation:
        return "chance"
    if trial.score.visibility < options.min_visibility:
        # What could be stronger than its bound lets it is not what the free parameters do as well.
        return "bound" if _at_an_end(trial) and trial.reduction >= options.far else "masked"
    if trial.held_out is None:
        return ""
    found = on_data_left_out(trial.stage, trial.held_out, options, untouched_by(trial.effect))
    if found or trial.strengths is None or agrees(trial, trial.strengths, options):
        return found
    return "varies"


def _at_an_end(trial: Trial) -> bool:
    """Is the strength at an end of its bounds where the effect does something?"""
    spec = trial.amplitude
    ends = (end for end in (spec.lower, spec.upper) if end != spec.default)
    return any(abs(trial.strength - end) <= AT_NULL * (spec.upper - spec.lower) for end in ends)


def stands_at_a_bound(model: Model, effect: Effect) -> bool:
    """Is an effect at the end of what it can be?

    A strength may be at its null, and what may vanish at 0. A time constant, or whatever else is searched by factors,
    is at neither end of its range where the effect is the true one.
    """
    for value in (v for v in model.values if v.term == effect.name and not v.fixed):
        if value.key != effect.strength_key and value.parameter.scale != "log":
            continue
        at = float(Transformation.of([value]).to_box(np.array([value.value]))[0])
        sides = {value.lower: at, value.upper: 1.0 - at}
        if value.key == effect.strength_key:
            sides.pop(effect.null, None)
        if min(sides.values()) <= AT_NULL:
            return True
    return False


def outlasts(model: Model, effect: Effect, runs: Sequence[Run]) -> bool:
    """Is a time constant of an effect longer than the longest run?

    Then no run shows where it ends, and whatever else is slow may do as well.
    """
    longest_s = max(float(series.time_s[-1] - series.time_s[0]) for run in runs for series in run.measured.values())
    own = (v for v in model.values if v.term == effect.name and v.unit == "s" and not v.fixed)
    return any(v.value > longest_s and v.parameter.name not in effect.in_durations for v in own)


def on_data_left_out(
    stage: StageProblem, held_out: HeldOut, options: DiagnoseOptions, untouched: Channel | None = None
) -> Objection:
    """Does the error of data left out rise, or hardly fall?"""
    before, after = held_out.errors.judged_before, held_out.errors.judged_after
    if gets_worse(stage, held_out, options, untouched):
        return "worse"
    worth = any(
        before.mean_square(c) - after.mean_square(c) > options.worth_noise
        and share_removed(before, after, c) > options.worth_share
        for c in before.total
    )
    return "" if worth else "small"


def gets_worse(
    stage: StageProblem, held_out: HeldOut, options: DiagnoseOptions, untouched: Channel | None = None
) -> bool:
    """Does the error of a sensor rise on the data left out?"""
    errors = held_out.errors
    return rises(stage, errors.judged_before, errors.judged_after, options.worse, options, untouched)


def rises(
    stage: StageProblem,
    before: Misfit,
    after: Misfit,
    allowed: float,
    options: DiagnoseOptions,
    untouched: Channel | None = None,
) -> bool:
    """Does the error of a sensor of the stage rise by more than the share allowed, beyond the noise?

    A sensor of another stage may rise by as much as it may be bent; what lies behind the heat, whose temperature an
    effect of the heat corrects, also by half of what the temperature gains. Where the effect explains the temperature,
    a displacement that was far from explained without it does not speak: something is missing behind the heat as well,
    which the wrong temperature may have hidden. Nor does one that is ``untouched`` by the effect, in whose trial all is
    fitted together: a refit that bends the heat is not kept, the heat is fitted alone then.
    """
    falls = {c: before.mean_square(c) - after.mean_square(c) for c in before.total}
    most = max((fall for c, fall in falls.items() if c in stage.channels), default=0.0)
    explained = all(after.mean_square(c) <= options.explained**2 for c in stage.channels if c in after.total)
    for channel, fall in falls.items():
        behind = stage.part == "heat" and channel not in stage.channels
        own = channel in stage.channels
        if channel is untouched and own:
            continue
        if behind and explained and before.mean_square(channel) > options.near**2:
            continue
        scale = max(before.mean_square(channel), NOISE)
        limit = allowed * scale if own else max(options.bent * scale, 0.5 * most if behind else 0.0)
        if after.mean_square(channel) > NOISE and -fall > limit:
            return True
    return False


def agrees(trial: Trial, strengths: Strengths, options: DiagnoseOptions) -> bool:
    """Is the strength of the runs one strength, as far as their errors can tell, and that of all of them together?

    Neither may lie within its own errors of the null value.

    Where the effect reads what is one number in every run, no run by itself shows a strength: nothing is asked.
    """
    if differs_between_runs_only(trial.effect, [i.run for i in trial.fit.problem.inputs]):
        return True
    overall, mean, null = strengths.overall, strengths.mean, trial.amplitude.default
    if any(abs(e.value - null) <= options.agreement * e.standard_error for e in (mean, overall)):
        return False
    error = max(mean.standard_error, overall.standard_error)
    return abs(overall.value - mean.value) <= max(options.agreement * error, options.alike * abs(mean.value - null))
