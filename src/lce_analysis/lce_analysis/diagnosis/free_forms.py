# SPDX-License-Identifier: Apache-2.0
"""Is an effect missing whatever the forms of the base model are? Free curves in the place of these say so.

A base model that does not hold the law of a strip leaves much, and what an effect takes of that says little: it may
stand in for the law. Two curves make the base model general: the temperature that the order follows, over the
temperature, which is any form of the order; and the strain over the displacement, which is any law of the stretch. An
effect that stands in for either takes hardly anything beside them. One that is there still takes most: creep goes on
while the temperature stays.

The curves are no part of the answer. An effect that is a curve itself, as thermal expansion is, is not asked: a form of
the base model may be wrong in just that way.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from lce_analysis.diagnosis.accepted import Step
from lce_analysis.diagnosis.general_form import GeneralForm, general_form, refitted_with_curve
from lce_analysis.diagnosis.held_out import HeldOut
from lce_analysis.diagnosis.linearized_fit import refit
from lce_analysis.diagnosis.looking_back import explains_most, take_back_refuted
from lce_analysis.diagnosis.score import score_test
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.diagnosis.strength import strengths_of
from lce_analysis.diagnosis.trial import Trial, agrees
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.options import DiagnoseOptions
from lce_data.channels import DISPLACEMENT
from lce_data.progress import Progress
from lce_model.effects import Effect

FORMS: Final = (GeneralForm("order", "temperature"), GeneralForm("strain", "displacement"))
"""What the base models say of the deformation, as curves."""
ITERATIONS: Final = 40


@dataclass(frozen=True)
class _Asked:
    """An effect refitted beside the base model as it is, ``trial``, and beside free curves, ``general``."""

    trial: Trial
    general: StageProblem


def with_free_forms(stage: StageProblem, options: DiagnoseOptions, progress: Progress) -> StageProblem:
    """A stage refitted with the curves of :data:`FORMS`, one after the other."""
    for form in FORMS:
        fit = refitted_with_curve(stage, form, options, progress)
        if fit is not None and fit.error < stage.fit.error:
            stage = replace(stage, fit=fit)
    return stage


def name_behind_wrong_forms(search: Search) -> None:
    """Accept the effect of the deformation that takes most beside free curves, where nothing else was found.

    Asked is where the base model leaves the displacement far from explained, and its temperature is the model's own.
    The final tables have to bear the effect out, beside the base model as it is.
    """
    stage, options = search.present.deformation, search.options
    if stage is None or stage.drive == "measured" or search.present.model.varies or search.of_part(False, Step):
        return
    if search.present.mean_squares.get(DISPLACEMENT, 0.0) <= options.near**2:
        return
    stage = search.refitted(search.present.model).deformation  # on the grid of the search
    if stage is None:
        return
    general = with_free_forms(stage, options, search.progress)
    asked = [one for effect in _promising(search, general) if (one := _asked(search, stage, effect)) is not None]
    if not asked:
        return
    asked.sort(key=lambda one: _left(one.general))
    # The curves alone may have ended in a poor minimum, which would speak for any effect.
    alone = min(general, _without(asked[0], search), key=_left)
    held_out = [_held_out(search, alone, one) for one in asked]
    passing = [one for one, errors in zip(asked, held_out, strict=True) if _takes_most(search, alone, one, errors)]
    if asked[0] not in passing:
        return
    names, trial = tuple(one.trial.effect.name for one in passing), passing[0].trial
    search.free_forms[names[0]] = held_out[0]
    search.accept_trial(trial, names)
    take_back_refuted(search)
    if not search.of_part(False, Step):
        search.trials.reject(replace(trial, held_out=held_out[0]), "hidden")


def _promising(search: Search, general: StageProblem) -> Sequence[Effect]:
    """The few effects of the deformation that promise most, and a fair share, beside free curves.

    Not those that are a curve themselves: a form of the base model may be wrong in just that way.
    """
    behind = (effect for effect in general.candidates if not acts_on_temperature(effect))
    candidates = [effect for effect in behind if general_form(effect) is None]
    tested = score_test(general.fit, candidates, critical_value=0.0)  # what would be seen is not asked
    fair = [score.effect for score in tested.scores if score.predicted_reduction >= search.options.far]
    return fair[: search.options.contenders]


def _asked(search: Search, stage: StageProblem, effect: Effect) -> _Asked | None:
    """An effect beside the base model, and then the curves beside both; None if the temperature would not bear it."""
    trial = search.trials.of(effect, [stage])
    found = search.refitted(search.with_effect_of(trial)).deformation
    if found is None or found.drive == "measured":
        return None
    return _Asked(trial, with_free_forms(found, search.options, search.progress))


def _without(one: _Asked, search: Search) -> StageProblem:
    """The curves without the effect, refitted from where they stand beside it."""
    problem, effect = one.general.fit.problem, one.trial.effect
    null = {v.key: v.parameter.default for v in problem.model.values if v.term == effect.name}
    free = tuple(i for i in problem.free if problem.model.values[i].term != effect.name)
    problem = replace(problem, model=problem.model.set(null), free=free)
    return replace(one.general, fit=refit(problem, f"without {effect.name}", search.progress, ITERATIONS))


def _left(stage: StageProblem) -> float:
    """Mean squared error of the displacement, in units of the noise."""
    return stage.fit.mean_squares[DISPLACEMENT]


def _held_out(search: Search, alone: StageProblem, one: _Asked) -> HeldOut:
    return search.left_out.errors(alone, one.general.fit.problem, f"{one.trial.effect.name} beside free curves")


def _takes_most(search: Search, alone: StageProblem, one: _Asked, held_out: HeldOut) -> bool:
    """Does the effect take most of what the curves leave, in the runs and of data left out, with one strength?"""
    models = alone.fit.problem.model, one.general.fit.problem.model
    in_the_runs = search.data.judged.pair(*models, "model", [DISPLACEMENT])
    found = strengths_of(one.general.fit, one.trial.effect)
    if found is None or not agrees(replace(one.trial, strengths=found), found, search.options):
        return False
    return explains_most(held_out.errors, in_the_runs, DISPLACEMENT, search.options)
