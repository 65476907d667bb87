# SPDX-License-Identifier: Apache-2.0
"""Is an effect missing whatever the forms of the base model are? Free curves in the place of these say so.

A base model that does not hold the law of a strip leaves much, and what an effect takes of that says little: it may
stand in for the law. Two curves make the base model more general: the temperature that the order follows, over the
temperature; and the strain over the displacement, which is any law of the stretch. Both have one value for heating and
cooling, so the shape of the loop stays the base model's. An effect that stands in for either form takes hardly anything
beside them. One that is there still takes most: creep goes on while the temperature stays.

The curves are no part of the answer. An effect that is a curve itself, as thermal expansion is, is not asked: a form of
the base model may be wrong in just that way.
"""

from dataclasses import dataclass, replace
from typing import Final

from lce_analysis.diagnosis.accepted import Step
from lce_analysis.diagnosis.general_form import ITERATIONS, GeneralForm, general_form, refitted_with_curve
from lce_analysis.diagnosis.held_out import HeldOut
from lce_analysis.diagnosis.linearized_fit import refit
from lce_analysis.diagnosis.looking_back import take_back_refuted, takes_most
from lce_analysis.diagnosis.misfit import Misfit, Pair, share_of
from lce_analysis.diagnosis.score import score_test
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.diagnosis.strength import strengths_of
from lce_analysis.diagnosis.trial import Trial, agrees, outlasts, stands_at_a_bound
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.options import DiagnoseOptions
from lce_data.channels import DISPLACEMENT
from lce_data.progress import Progress
from lce_model.effects import Effect

FORMS: Final = (GeneralForm("order", "temperature"), GeneralForm("strain", "displacement"))
"""What the base models say of the deformation, as curves."""


@dataclass(frozen=True)
class _Contender:
    """An effect refitted beside the base model as it is, ``trial``, and beside free curves, ``general``."""

    trial: Trial
    general: StageProblem

    @property
    def name(self) -> str:
        """Of the effect."""
        return self.trial.effect.name


def with_free_forms(stage: StageProblem, options: DiagnoseOptions, progress: Progress) -> StageProblem:
    """A stage refitted with the curves of :data:`FORMS`, one after the other."""
    for form in FORMS:
        fit = refitted_with_curve(stage, form, options, progress)
        if fit is not None and fit.error < stage.fit.error:
            stage = replace(stage, fit=fit)
    return stage


def name_behind_wrong_forms(search: Search) -> None:
    """Accept the effect of the deformation that takes most beside free curves, where nothing else was found.

    It runs only where the base model leaves the displacement beyond ``near`` times its noise, and the temperature of
    the model drives the deformation. The final tables, beside the base model as it is, have to bear the effect out.
    """
    stage = _worth_asking(search)
    if stage is None:
        return
    known = dict(search.trials.tried)
    passing = _contenders(search, stage)
    # What is known of the others from beside the base model as it is stays as it was.
    search.trials.tried = known
    if not passing:
        return
    (best, held_out), *others = passing
    alike = [one.name for one, _ in others if _left(one.general) - _left(best.general) < search.options.worth_noise]
    search.free_forms[best.name] = held_out
    search.accept_trial(best.trial, (best.name, *alike))
    take_back_refuted(search)
    refused = search.trials.tried.get(best.name)
    if refused is not None and refused.objection in ("small", "worse") and not search.of_part(False, Step):
        search.trials.reject(refused, "hidden")


def _worth_asking(search: Search) -> StageProblem | None:
    """The deformation on the grid of the search, where much is left of it and nothing was found; else None."""
    present = search.present
    if present.model.varies or search.of_part(False, Step):
        return None
    if present.mean_squares.get(DISPLACEMENT, 0.0) <= search.options.near**2:
        return None
    stage = search.refitted(present.model).deformation
    return None if stage is None or _driven(stage) else stage


def _driven(stage: StageProblem) -> bool:
    """Does a measured temperature drive the deformation?"""
    return stage.drive == "measured" or any(one.driven for one in stage.fit.problem.inputs)


def _contenders(search: Search, stage: StageProblem) -> list[tuple[_Contender, HeldOut]]:
    """The effects that take most of what free curves leave, the best first; none if the one that leaves least does not.

    Where the curves alone take hardly anything, the forms of the base model are not what is wrong. Asked are few: those
    that promise most beside the curves, and a fair share; and those that took one beside the base model as it is. With
    each come the errors of the displacement in data left out, without the effect and with it.
    """
    effects = [e for e in stage.candidates if not acts_on_temperature(e) and general_form(e) is None]
    if not effects:
        return []
    general = with_free_forms(stage, search.options, search.progress)
    if share_of(_left(stage), _left(general)) < search.options.far:
        return []
    tested = score_test(general.fit, effects, critical_value=0.0)  # `detectable` is not used here
    fair = [score.effect for score in tested.scores if score.predicted_reduction >= search.options.far]
    took = [e for e in effects if (t := search.trials.tried.get(e.name)) and t.reduction >= search.options.far]
    few = list(dict.fromkeys([*fair, *took]))[: search.options.contenders]
    asked = [one for effect in few if (one := _beside_both(search, stage, effect)) is not None]
    if not asked:
        return []
    asked.sort(key=lambda one: _left(one.general))
    # The curves alone may have ended in a poor minimum, which would speak for any effect.
    alone = min(general, _without(asked[0], search), key=_left)
    best, *others = [(one, _held_out(search, alone, one)) for one in asked]
    if not _takes_most(search, alone, *best):
        return []
    return [best, *(other for other in others if _takes_most(search, alone, *other))]


def _beside_both(search: Search, stage: StageProblem, effect: Effect) -> _Contender | None:
    """An effect beside the base model, then with the curves; None if the measured temperature would drive it."""
    trial = search.trials.of(effect, [stage])
    found = search.refitted(search.with_effect_of(trial)).deformation
    if found is None or _driven(found):
        return None
    return _Contender(trial, with_free_forms(found, search.options, search.progress))


def _without(one: _Contender, search: Search) -> StageProblem:
    """The curves without the effect, refitted from where they stand beside it."""
    problem = one.general.fit.problem
    null = {v.key: v.parameter.default for v in problem.model.values if v.term == one.name}
    free = tuple(i for i in problem.free if problem.model.values[i].term != one.name)
    problem = replace(problem, model=problem.model.set(null), free=free)
    iterations = min(ITERATIONS, search.options.iterations)
    return replace(one.general, fit=refit(problem, f"without {one.name}", search.progress, iterations))


def _left(stage: StageProblem) -> float:
    """Mean squared error of the displacement, in units of the noise."""
    return stage.fit.mean_squares[DISPLACEMENT]


def _held_out(search: Search, alone: StageProblem, one: _Contender) -> HeldOut:
    """Errors of the displacement: with the effect the heat may have been fitted apart, and without it not."""
    found = search.left_out.errors(alone, one.general.fit.problem, f"{one.name} beside free curves")
    errors = found.errors
    misfits = (errors.before, errors.after, errors.judged_before, errors.judged_after)
    return replace(found, errors=Pair(*(_of_displacement(misfit) for misfit in misfits)))


def _of_displacement(misfit: Misfit) -> Misfit:
    return Misfit({DISPLACEMENT: misfit.total[DISPLACEMENT]}, {DISPLACEMENT: misfit.samples[DISPLACEMENT]})


def _takes_most(search: Search, alone: StageProblem, one: _Contender, held_out: HeldOut) -> bool:
    """Does the effect take most of what the curves leave, in the runs and of data left out, with one strength?

    At an end of what it can be, or with a time constant longer than the runs, it may stand in for something else.
    """
    models = alone.fit.problem.model, one.general.fit.problem.model
    effect, runs = one.trial.effect, search.data.judged.runs
    if stands_at_a_bound(models[1], effect) or outlasts(models[1], effect, runs):
        return False
    found = strengths_of(one.general.fit, effect)
    if found is None or not agrees(replace(one.trial, strengths=found), found, search.options):
        return False
    in_the_runs = search.data.judged.pair(*models, "model", [DISPLACEMENT])
    return takes_most(DISPLACEMENT, search.options, held_out.errors, in_the_runs)
