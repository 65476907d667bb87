# SPDX-License-Identifier: Apache-2.0
"""What was accepted has to prove itself once more beside what came after it: take back what does not."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from lce_analysis.diagnosis.accepted import Accepted, Change, Step, VariationStep
from lce_analysis.diagnosis.chain import Chain
from lce_analysis.diagnosis.general_form import drifts, general_form, refitted_with_curve
from lce_analysis.diagnosis.misfit import NOISE, Pair, reduction, share_of
from lce_analysis.diagnosis.stage_problem import StagedFit
from lce_analysis.diagnosis.strength import strengths_of
from lce_analysis.diagnosis.trial import (
    Objection,
    on_data_left_out,
    outlasts,
    rises,
    stands_at_a_bound,
    untouched_by,
)
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.options import DiagnoseOptions, Drive
from lce_analysis.signatures import residual_series, signatures
from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_model import Model

SIGNATURES: Final = {"displacement_drift": ("drift", DISPLACEMENT)}
"""Effects that a residual shows at once: the name of the signature, and the sensor."""
USUAL_BLOCK: Final = 110.0
"""Samples of a camera at 10 Hz in a block of 10 s, rounded up, for which ``inflated`` is meant."""


def keep_what_explains(chain: Chain, heat: bool) -> None:
    """Keep, of what was accepted in the heat or behind it, what explains most of what that part of the model left.

    Parameters that differ from run to run stay only if all of them together do. What was taken back may have mended
    what another effect leaves, so all is asked again.
    """
    kept: list[str] | None = None
    while kept != (left := [accepted.label for accepted in chain.accepted]):
        kept = left
        _take_back_needless_differences(chain, heat)
        _take_back_other_forms(chain, heat)
        _take_back_parts(chain, heat)
        if _take_out_differences_that_explain_too_little(chain, heat):
            _take_back_parts(chain, heat)


def take_back_superfluous(chain: Chain) -> None:
    """Take out effects that later additions have made superfluous."""
    for step in chain.steps[:-1]:
        reference = step.trial.effect.reference
        without = chain.refitted(chain.present.model.without(reference))
        pair = chain.of_the_runs(without.model)
        before, after = pair.judged_before, pair.judged_after
        if any(before.mean_square(c) - after.mean_square(c) >= chain.options.worth_noise for c in before.total):
            continue
        chain.trials.reject(step.trial, "less")
        chain.take_out(step, without, partial(Model.without, effect=reference))


def take_back_refuted(chain: Chain) -> None:
    """Take back effects, the last of a part first, until the final tables bear that one out.

    What differs from run to run beside an effect that is taken back has to explain most without it as well.
    """
    while refuted := next(_refuted(chain), None):
        step, reason = refuted
        chain.drop(step, reason)
        _take_out_differences_that_explain_too_little(chain, step.trial.stage.part == "heat")
        _take_back_other_forms(chain, step.trial.stage.part == "heat")
        chain.finish()


def not_borne_out(step: Step, options: DiagnoseOptions) -> Objection:
    """What the final tables say against a step: not less error in the runs and on data left out, or hardly less."""
    before, after = step.held_out.before, step.held_out.after
    channels = [c for c in step.trial.stage.channels if c in before.total]
    falls = step.actual_reduction > 0.0 and any(after.mean_square(c) < before.mean_square(c) for c in channels)
    stage, untouched = step.trial.stage, untouched_by(step.trial.effect)
    if not falls or rises(stage, *step.train, options.bent, options) or bends_the_heat(step, options):
        return "worse"
    return on_data_left_out(stage, step.held_out, options, untouched)


def bends_the_heat(step: Step, options: DiagnoseOptions) -> bool:
    """Does an effect of the heat mend the displacement at the expense of the temperature, its own sensor?"""
    trial, (before, after) = step.trial, step.train
    if trial.stage.part != "both" or TEMPERATURE not in before.total or not acts_on_temperature(trial.effect):
        return False
    return after.mean_square(TEMPERATURE) > (1.0 + options.worse) * before.mean_square(TEMPERATURE)


def _refuted(chain: Chain) -> Iterator[tuple[Step, Objection]]:
    """The last effect of each part of the model that the final tables do not bear out, and why."""
    for heat in (False, True):
        effects = chain.of_part(heat, Step)
        for last in effects[-1:]:
            reason = not_borne_out(last, chain.options) or _serves_these_runs_alone(chain, last)
            reason = reason or _stands_in(chain, last)
            if reason and not (reason == "part" and last.added in chain.bearing):
                yield last, reason


def _serves_these_runs_alone(chain: Chain, last: Step) -> Objection:
    """Where something differs from run to run, is the final model worse than the base in the runs held out?

    What differs, and an effect beside it, can explain the runs that they were fitted to, and no other. Both models have
    the values of all runs there, but for an ambient temperature that the final one reads off the run itself.
    """
    if not chain.of_part(last.trial.stage.part == "heat", VariationStep):
        return ""
    before, after = (chain.misfit(fit.model, chain.present.drive, chain.tests) for fit in (chain.base, chain.present))
    options, untouched = chain.options, untouched_by(last.trial.effect)
    return "worse" if rises(last.trial.stage, before, after, options.worse, options, untouched) else ""


def _take_back_needless_differences(chain: Chain, heat: bool) -> None:
    """Take back what differs from run to run only because an effect was still missing.

    A run that does not begin at the ambient temperature of all has a start of its own. Where it has an ambient
    temperature of its own instead, taking that back makes nothing simpler, and it stays.
    """
    for step in [s for s in chain.of_part(heat, Change)[:-1] if isinstance(s, VariationStep)]:
        part = step.trial.stage.part
        model = _without_difference(chain.present.model, step.key)
        without = chain.refitted_part(model, part)
        old, new = without.stage(part), chain.present.stage(part)
        if old is None or new is None or old.channels != new.channels:
            continue
        if old.fit.independent >= new.fit.independent:
            continue
        errors = chain.left_out.errors(old, new.fit.problem, f"{step.key} of each run")
        if not on_data_left_out(step.trial.stage, errors, chain.options):
            continue
        _take_out_difference(chain, step, chain.refitted(model) if part == "heat" else without)


def _take_back_other_forms(chain: Chain, heat: bool) -> None:
    """Take back effects of this part of the model at whose place a free curve explains what they do not.

    Not the last one if a parameter of it is at a bound: further on it may have the form.
    """
    while steps := chain.of_part(heat, Step):
        asked = steps[:-1] if _is_at_a_bound(chain, steps[-1]) else steps
        other = next((step for step in asked if _has_another_form(chain, step)), None)
        if other is None:
            return
        chain.drop(other, "form")


def _has_another_form(chain: Chain, step: Step) -> bool:
    """Does a free curve at the place of an effect explain a sensor that the effect leaves unexplained?

    So it does where what is missing acts there, and has another form. The curve has to take most of what the effect
    leaves, the more of it the more the curve leaves itself, on data left out as well. What was found after the effect
    may only mend the difference; it must leave clearly more than the curve does. Effects that together leave no more
    than a curve explain it as well, by fewer numbers.
    """
    options, part, untouched = chain.options, step.trial.stage.part, untouched_by(step.trial.effect)
    form, alone, together = general_form(step.trial.effect), step.with_it.stage(part), chain.present.mean_squares
    if form is None or alone is None or not set(step.trial.stage.channels) <= set(alone.channels):
        return False
    if alone.explained(options, untouched):
        return False
    curve = refitted_with_curve(alone, form, options, chain.progress)
    if curve is None:
        return False

    def explains(channel: Channel, left: float, by_curve: float) -> bool:
        beyond = channel is not untouched and left > options.explained**2
        return beyond and share_of(left, by_curve) >= _share_needed(by_curve, False, options)

    own, by_curve = alone.fit.mean_squares, curve.mean_squares
    found = [c for c in own if explains(c, own[c], by_curve[c]) and by_curve[c] < together[c] - options.worth_noise]
    if not found:
        return False
    errors = chain.left_out.errors(alone, curve.problem, "a free curve").errors
    before, after = errors.judged_before, errors.judged_after
    return any(explains(c, before.mean_square(c), after.mean_square(c)) for c in found if c in before.total)


def _take_back_parts(chain: Chain, heat: bool) -> None:
    """Take back effects of this part of the model, the last first, until the last explains most.

    One that takes most beside all of them stays, although by itself it may leave as much as something else would.
    """
    looked = False
    while (effects := chain.of_part(heat, Step)) and (reason := _stands_in(chain, effects[-1])):
        if not looked:
            chain.bearing |= _bearing(chain, effects)
            looked = True
        if reason == "part" and effects[-1].added in chain.bearing:
            return
        chain.drop(effects[-1], reason)
        _take_back_needless_differences(chain, heat)


def _bearing(chain: Chain, effects: Sequence[Step]) -> frozenset[str]:
    """Those of several effects of the heat without each of which most of its error would come back.

    So the last of them, which may only resemble what is missing, makes room for those before it even where it is taken
    back itself. Of the deformation it is not known whether what stands in for something else does that as well. Nothing
    differs from run to run here: with values of their own, most is easily taken by what resembles the true effect. So
    none is named of a model that was given with such values.
    """
    heat = [step for step in effects if step.trial.stage.part == "heat"]
    if len(heat) < 2 or chain.given.varies:
        return frozenset()
    alike = chain.present
    if alike.model.varies:
        alike = chain.refitted_part(alike.model.varying({}), "heat")
    return frozenset(step.added for step in heat if _takes_most_beside_the_others(chain, alike, step))


def _takes_most_beside_the_others(chain: Chain, alike: StagedFit, step: Step) -> bool:
    """Beside all effects that were accepted, does it take most of the error, of the runs and of data left out?"""
    with_it = alike.stage("heat")
    without = chain.refitted_part(alike.model.without(step.trial.effect.reference), "heat").stage("heat")
    if with_it is None or without is None:
        return False
    held_out = [
        chain.left_out.errors(without, with_it.fit.problem, step.added),
        chain.left_out.on_test_runs(without, without.fit.problem.model, with_it.fit.problem.model),
    ]
    pairs = [(h.errors.judged_before, h.errors.judged_after) for h in held_out if h is not None]
    errors = [(before.mean_square(TEMPERATURE), after.mean_square(TEMPERATURE)) for before, after in pairs]
    errors.append((without.fit.mean_squares[TEMPERATURE], with_it.fit.mean_squares[TEMPERATURE]))
    return all(share_of(before, after) >= _share_needed(after, False, chain.options) for before, after in errors)


def _take_out_differences_that_explain_too_little(chain: Chain, heat: bool) -> bool:
    """Take out all that differs from run to run in a part of the model, unless it explains most; whether it was."""
    steps = chain.of_part(heat, VariationStep)
    if not steps or _differences_explain(chain, heat):
        return False
    for step in reversed(steps):
        _take_out_difference(chain, step, chain.refitted(_without_difference(chain.present.model, step.key)))
    return True


def _differences_explain(chain: Chain, heat: bool) -> bool:
    """Do all parameters that differ from run to run together take most of what would be left without them?"""
    steps = chain.of_part(heat, VariationStep)
    kept = {key: v for key, v in chain.present.model.varies.items() if key not in {s.key for s in steps}}
    without = chain.refitted_part(chain.present.model.varying(kept), steps[-1].trial.stage.part)
    return _explains(steps[-1], chain.present.drive, chain.options, chain.of_the_runs(without.model))


def _stands_in(chain: Chain, last: Step) -> Objection:
    """Why the last effect may stand in for something else; nothing if it is what was missing."""
    if _leaves_its_shape(chain, last):
        return "resembles"
    if _is_at_a_bound(chain, last):
        return "bound"
    if _worst(chain, last) > chain.options.explained**2 and outlasts(
        chain.present.model, last.trial.effect, chain.data.judged.runs
    ):
        return "long"
    proven = last.added in chain.free_forms or _explained(chain, last) or _seen_at_once(chain, last)
    return "" if proven else "part"


def _seen_at_once(chain: Chain, last: Step) -> bool:
    """Does the residual without the effect have a signature that nothing but this effect has?

    Then it is named although a wrong base model leaves much beside it. The reading of a sensor that drifts grows
    straight with time, by the same amount in every run: what a base model has wrong follows what the strip does.
    """
    own = SIGNATURES.get(last.added)
    if own is None:
        return False
    beside = residual_series(chain.whole(last.without.model), chain.data.judged.runs, chain.present.drive)
    return any((one.name, one.channel) == own for one in signatures(beside))


def _explained(chain: Chain, last: Step) -> bool:
    """Does the last effect take most of what would be left without it?

    Where nothing differs from run to run, on data left out and in the runs; else of the runs, with what differs on
    either side, and of the error of the runs held out. Beside what was found to differ in its part of the model it has
    to take nearly all of what it does not explain: with values of its own for each run, most is easily taken by what
    resembles the true effect.
    """
    options, stage = chain.options, last.trial.stage
    if not chain.present.model.varies:
        return _explains(
            last, chain.present.drive, options, last.held_out.errors, chain.of_the_runs(last.without.model)
        )
    if chain.of_part(stage.part == "heat", VariationStep):
        options = replace(options, near=options.explained)
    without = chain.refitted_part(chain.present.model.without(last.trial.effect.reference), stage.part)
    tested = chain.left_out.on_test_runs(stage, without.model, chain.present.model)
    if tested is not None:
        errors = tested.errors
        if reduction(errors.judged_before, errors.judged_after, stage.channels) < options.most:
            return False
    return _explains(last, chain.present.drive, options, chain.of_the_runs(without.model))


def _leaves_its_shape(chain: Chain, last: Step) -> bool:
    """Does an effect of the heat leave what has its own shape, and so only resemble the true one?

    With the true effect, noise is left, and the errors of its strength are those that noise gives it. A loss of another
    form leaves a residual that pulls at its strength, one way here and the other way there: errors clustered in time
    grow far beyond (the sandwich of White 1982 against the plain ones). Where the temperature is not explained, the
    base model lacks something else as well, but that lies anywhere in the runs: they have to grow beyond what it does.
    Where more is left, and of the deformation, most of which is not explained, this says nothing. Nor does a drift have
    a shape of its own.
    """
    stage = chain.present.stage("heat")
    if last.trial.stage.part != "heat" or stage is None or drifts(last.trial.effect):
        return False
    options, left = chain.options, max(stage.fit.mean_squares.values())
    found = strengths_of(stage.fit, last.trial.effect) if left <= options.near**2 else None
    if found is None:
        return False
    anywhere = 0.0 if left <= options.explained**2 else (left - NOISE) * found.samples_per_block
    # Noise that is correlated from sample to sample inflates in proportion to the samples.
    dense = max(1.0, found.samples_per_block / USUAL_BLOCK)
    return found.inflation > max(options.inflated * dense, options.concentrated * anywhere)


def _is_at_a_bound(chain: Chain, last: Step) -> bool:
    """Is the effect at the end of what it can be, and even so leaves more than noise of a sensor?"""
    if _worst(chain, last) <= NOISE + chain.options.worth_noise:
        return False
    return stands_at_a_bound(chain.present.model, last.trial.effect)


def _worst(chain: Chain, last: Step) -> float:
    """Mean squared error of the sensor that is left worst, of those that the last effect acts on; 0 without one."""
    stage = chain.present.stage(last.trial.stage.part)
    left = {} if stage is None else stage.fit.mean_squares
    judged = set(last.trial.stage.channels) - {untouched_by(last.trial.effect)}
    return max((x for channel, x in left.items() if channel in judged), default=0.0)


def _take_out_difference(chain: Chain, step: VariationStep, without: StagedFit) -> None:
    chain.take_out(step, without, partial(_without_difference, key=step.key))


def _without_difference(model: Model, key: str) -> Model:
    return model.varying({k: v for k, v in model.varies.items() if k != key})


def _explains(last: Accepted, drive: Drive, options: DiagnoseOptions, *judged: Pair) -> bool:
    """Does the last change of a part of the model take most of what was left of the error of a sensor?

    If not, it stands in for something else, that the library or the base model lacks. The more it leaves, the larger a
    share it has to take. A sensor that was at its noise before does not count, nor the temperature if the effect does
    nothing to it. Where the heat is not explained, and the measured temperature drives the deformation, when it is
    tried and in the end, the effect has to bring the displacement near its noise.

    drive : what drives the deformation in the end; another one may have when the change was tried.
    judged : errors before and after; those behind the first have to show it as well, unless they are explained.
    """
    driven = last.trial.stage.drive == drive == "measured"
    untouched = untouched_by(last.trial.effect) if isinstance(last, Step) else None
    channels = (c for c in last.trial.stage.channels if c in judged[0].judged_before.total and c is not untouched)
    for channel in (c for c in channels if judged[0].judged_before.above_noise(c) > options.worth_noise):
        errors = [(p.judged_before.mean_square(channel), p.judged_after.mean_square(channel)) for p in judged]
        close = max(after for _, after in errors) <= options.near**2
        most = [_takes(before, after, driven, options) for before, after in errors]
        also = all(taken or left <= options.explained**2 for taken, (_, left) in zip(most[1:], errors[1:], strict=True))
        if most[0] and also and (close or not driven):
            return True
    return False


def takes_most(channel: Channel, options: DiagnoseOptions, *judged: Pair) -> bool:
    """Does a change take most of what was left of a sensor, by errors before and after, all of them?"""
    errors = [(p.judged_before.mean_square(channel), p.judged_after.mean_square(channel)) for p in judged]
    return all(_takes(before, after, False, options) for before, after in errors)


def _takes(before: float, after: float, driven: bool, options: DiagnoseOptions) -> bool:
    """Is it worth having, and the share that the last effect has to take?"""
    return before - after > options.worth_noise and share_of(before, after) >= _share_needed(after, driven, options)


def _share_needed(left: float, driven: bool, options: DiagnoseOptions) -> float:
    """The share of an error above the noise that the last effect has to take, by the mean square that it leaves."""
    if driven:
        return options.nearly_all
    ends = [options.explained, options.near], [options.most, options.nearly_all]
    return float(np.interp(math.sqrt(left), *ends))
