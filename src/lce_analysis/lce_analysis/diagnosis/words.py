# SPDX-License-Identifier: Apache-2.0
"""The answer in sentences; none says more than its table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from lce_analysis.diagnosis.disturbed import outside
from lce_analysis.diagnosis.held_out import HeldOut
from lce_analysis.diagnosis.misfit import NOISE, Misfit
from lce_analysis.diagnosis.stage_problem import Part
from lce_analysis.diagnosis.structure import TOLD
from lce_analysis.diagnosis.trial import Objection, untouched_by
from lce_analysis.jumps import LEFT_OUT_S
from lce_analysis.signatures.signature import DISCOVER
from lce_data.channels import DISPLACEMENT, SENSORS, Channel
from lce_data.units import after_number

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from lce_analysis.diagnosis.accepted import Step, VariationStep
    from lce_analysis.diagnosis.diagnosis import Diagnosis
    from lce_analysis.diagnosis.other_base import OtherBase
    from lce_analysis.diagnosis.trial import Trial
    from lce_model import Model


PARTS: Final[Mapping[Part, str]] = {
    "heat": "the heat (P → T)",
    "deformation": "the deformation (T → d)",
    "both": "the heat (P → T), and perhaps the deformation (T → d) behind it",
}

UNNAMED: Final[Mapping[Objection, str]] = {
    "part": "explains a part of it{fall} and leaves too much to be named: it may stand in for something else, or it is "
    "there and the base model is wrong as well",
    "resembles": "takes much of it{fall}, but what it leaves still has its shape: something much like it is missing",
    "form": "takes much of it{fall}, but a free curve beside it takes most of the rest as well: what is missing acts "
    "there in another form, which `lce discover` looks for, or the base model is wrong in that way",
    "hidden": "takes most of what free curves in the place of the base model's forms leave{fall}, but beside these "
    "forms as they are the errors do not bear it out: look for better forms first (`lce discover`)",
    "bound": "explains a part of it{fall} with a parameter at its bound: it may stand in for something else, or the "
    "bound is too narrow",
    "long": "explains a part of it{fall} with a time constant longer than the runs: it may stand in for something else "
    "that is slow; longer runs tell",
}
"""What the answer says of an effect that explains much and that it does not name."""
ELSE: Final = "would explain a part of it{fall}; what was added explains it"
"""What the answer says of it instead, where nothing is left of the sensors that it was judged on."""
AT_JUMPS: Final = 1.1
"""Error on every sample over that away from jumps, from which on it is reported."""
BEYOND: Final = 1.1
"""Error of a sensor in units of its noise, from which on the answer says by how much the model is wrong."""
LESS_WELL: Final = 1.2
"""Error of a sensor in runs held out over that in the runs learnt from, from which on the answer says so."""
RISES: Final = 1.02
"""Squared error with an effect over that without, from which on the answer says that it rises."""
DEFAULT_THERMAL: Final = "lumped"
"""Of `lce fit`."""


def in_words(found: Diagnosis) -> Iterator[str]:
    """The verdict, then the stage at fault, what is left, traces, and what the data could not show.

    Before a verdict that names effects stands what a sensor or a disturbance from outside did.
    """
    if found.verdict in ("missing", "cannot_tell"):
        yield from (f"Look at this first: {one.words}. To try: {one.advice}." for one in outside(found.signatures))
    if found.other_base is not None:
        yield from _other_base(found.other_base, found.before.deformation)
    yield from _verdict(found)
    if found.verdict != "adequate":
        yield from _stage_at_fault(found)
    if found.steps and (left := _amounts(_told(found))):
        yield f"Beyond the noise of the sensors the model is still wrong by {left} rms."
    yield from _jumps(found)
    for bound in found.at_bounds:
        yield f"At a bound: {bound.sentence}."
    yield from _traces(found)
    if found.verdict == "unexplained" and found.other_base is None:
        advice = dict.fromkeys([*(one.advice for one in found.signatures[:TOLD]), DISCOVER])
        yield from (f"To try: {one}." for one in advice)
    yield from _left_out(found)
    masked = [c.effect.name for c in found.candidates if c.standing not in ("missing", "trace") and not c.score.shown]
    if masked and found.verdict != "unexplained":
        yield f"These data would not show, at any strength within its bounds: {', '.join(masked)}."


def _jumps(found: Diagnosis) -> Iterator[str]:
    """Error on every sample and away from jumps, if the two differ."""
    errors = found.train.misfit["after"], found.away_from_jumps
    everywhere, away = (misfit.rms.get(DISPLACEMENT, 0.0) for misfit in errors)
    if everywhere > AT_JUMPS * away:
        yield (
            f"In the runs learnt from, the model leaves {everywhere:.2f} × the noise in the displacement, and "
            f"{away:.2f} farther than {LEFT_OUT_S} s from its jumps, where a hundredth of a second decides."
        )


def _other_base(found: OtherBase, present: str) -> Iterator[str]:
    """Which base model to begin with, the errors that say so, and the effects that it lacks itself."""
    other, own = found.other.rms[DISPLACEMENT], found.present.rms[DISPLACEMENT]
    fewer = ", with fewer effects" if len(found.added) < len(found.effects) else ""
    away = f", away from its jumps{fewer}" if found.jumps else fewer
    yield (
        f"Begin with another base model: on {', '.join(found.runs)} the deformation model "
        f"{_with(found.deformation, found.added)} leaves {other:.2f} × the noise of the displacement{away}, "
        f"{_with(present, found.effects)} leaves {own:.2f}. `{_command(found.model)}` identifies it."
    )
    for step in found.steps:
        yield f"Beside {found.deformation}, {_named(step)}."


def _command(model: Model) -> str:
    """What identifies a model, less the runs and the file."""
    thermal = [] if model.thermal == DEFAULT_THERMAL else [f"--thermal {model.thermal}"]
    more = [*(f"--effect {effect}" for effect in model.effects), *(f"--varies {key}" for key in model.varies)]
    return " ".join(["lce fit", *thermal, f"--deformation {model.deformation}", *more])


def _with(deformation: str, effects: Sequence[str]) -> str:
    return f"{deformation} with {', '.join(effects)}" if effects else f"{deformation} alone"


def _traces(found: Diagnosis) -> Iterator[str]:
    """What explains much of the error and is left unnamed, and why; then what is too small to matter.

    Where nothing is missing, nothing explains much.
    """
    small = []
    for trace in found.traces:
        trial = trace.trial
        if found.verdict == "adequate" or trial is None or trial.objection not in UNNAMED:
            small.append(trace.effect.name)
        else:
            told = found.free_forms[trace.effect.name] if trial.objection == "hidden" else trial.held_out
            fall = f" ({changes(told.before, told.after)})" if told else ""
            said = ELSE if found.steps and _explained(found, trial) else UNNAMED[trial.objection]
            yield f"{trace.effect.name} {said.format(fall=fall)}."
            yield from (f"At a bound: {one.sentence}." for one in found.held_back.get(trace.effect.name, ()))
    if small:
        yield f"Significant, but too small to matter: {', '.join(small)}."


def _explained(found: Diagnosis, trial: Trial) -> bool:
    """Are the sensors that a trial was judged on within what is taken for their noise, with what was added?"""
    left = found.train.misfit["after"].rms
    return all(left[channel] <= BEYOND for channel in _deciding(trial) if channel in left)


def outcome(held_out: HeldOut, objection: str, deciding: Sequence[Channel] = SENSORS) -> str:
    """What data left out say of an effect: "confirmed on prbs: T 4.66 → 2.03 × noise, …".

    It is confirmed if the error of a deciding sensor falls, on every sample or at least away from the jumps.
    """
    on, told, errors = _on(held_out), changes(held_out.before, held_out.after), held_out.errors
    if objection:
        return f"not confirmed: {objection}; on {on}: {told}"
    if _falls(held_out.before, held_out.after, deciding):
        return f"confirmed on {on}: {told}"
    if _falls(errors.judged_before, errors.judged_after, deciding):
        away = changes(errors.judged_before, errors.judged_after)
        return f"confirmed on {on}, away from jumps: {away}; with them: {told}"
    return f"judged on {on}: {told}"


def _falls(before: Misfit, after: Misfit, channels: Sequence[Channel]) -> bool:
    return any(after.mean_square(c) < before.mean_square(c) for c in channels if c in before.total)


def changes(before: Misfit, after: Misfit) -> str:
    """RMS errors of two models in units of the noise: "T 4.66 → 2.03 × noise, d 9.40 → 2.29 × noise"."""
    old, new = before.rms, after.rms
    return ", ".join(f"{c.symbol} {old[c]:.2f} → {new[c]:.2f} × noise" for c in old)


def _on(held_out: HeldOut) -> str:
    if held_out.how == "test runs":
        return ", ".join(held_out.names)
    return {
        "each run in turn": "each run, left out in turn",
        "each block in turn": "each block of every run, left out in turn",
    }[held_out.how]


def _verdict(found: Diagnosis) -> Iterator[str]:
    if found.verdict == "unexplained" and found.other_base is not None:
        yield f"Beside {found.before.deformation}, {found.fingerprint}."
    elif found.verdict == "unexplained":
        yield f"{found.fingerprint[:1].upper()}{found.fingerprint[1:]}."
    if found.verdict == "adequate":
        nothing = "No effect is missing" if found.variations or found.other_base else "Nothing is missing"
        yield f"{nothing}: the model leaves {_levels(found.train.misfit['after'])}."
        yield from _held_out_levels(found, only_if_more=False)
    if found.verdict == "cannot_tell":
        yield (
            f"Something may be missing ({_levels(found.train.misfit['after'])}), but these data cannot tell what: "
            "of the effects that explain much of it, something speaks against each."
        )
    for step in found.steps:
        yield from _step(step)
        if held_out := found.free_forms.get(step.added):
            left = found.train.misfit["after"].rms[DISPLACEMENT]
            yield from _whatever_the_forms(step.added, held_out, left)
    for variation in found.variations:
        yield _variation(variation, found.model)
    if found.steps:
        yield from _held_out_levels(found, only_if_more=True)
    yield from _less_as_given(found)


def _less_as_given(found: Diagnosis) -> Iterator[str]:
    """Which sensor the model as given explains better, in the runs held out, than the refit with what was added."""
    given, after = found.test.misfit["given"], found.test.misfit["after"]
    for channel in after.total if found.steps else ():
        if after.mean_square(channel) > max(RISES * given.mean_square(channel), NOISE):
            yield (
                f"On {', '.join(found.held_out)} the model as given leaves less of the {channel.name}: "
                f"{given.rms[channel]:.2f} × the noise; refitted, with what was added, {after.rms[channel]:.2f}."
            )


def _held_out_levels(found: Diagnosis, only_if_more: bool) -> Iterator[str]:
    """What the model leaves of the runs held out, and whether that is clearly more than of the runs learnt from."""
    learnt, held_out = found.train.misfit["after"], found.test.misfit["after"]
    if not held_out.total:
        return
    more = any(held_out.rms[c] > LESS_WELL * max(learnt.rms.get(c, 0.0), 1.0) for c in held_out.total)
    told = ", more than of the runs learnt from" if more else ""
    if more or not only_if_more:
        yield f"Of {', '.join(found.held_out)}, held out, the model leaves {_levels(held_out)}{told}."


def _variation(step: VariationStep, model: Model) -> str:
    """What differs from run to run, between which values, and what data left out say of it."""
    value, by_run = model.values[model.index(step.key)], model.varies[step.key].by_run
    low, high = (choose(by_run, key=lambda name: by_run[name].value) for choose in (min, max))
    unit = after_number(value.unit)
    return (
        f"{step.key} ({value.parameter.description}) differs from run to run: {by_run[low].value:.4g}{unit} in {low} "
        f"to {by_run[high].value:.4g}{unit} in {high}; {outcome(step.held_out, '', step.trial.stage.channels)}. "
        f"`lce fit --varies {step.key}` gives each run its own."
    )


def _step(step: Step) -> Iterator[str]:
    yield f"{_named(step)}."
    yield (
        f"With it {step.actual_reduction:.0%} of the squared error above the noise goes "
        f"({step.predicted_reduction:.0%} was predicted before the refit)."
    )
    yield from _gets_worse(step)
    yield from _since(step)
    if others := step.alias_set[1:]:
        yield (
            f"In its place {', '.join(others)} would explain nearly as much; `lce design` finds the experiment that "
            "tells them apart."
        )


def _whatever_the_forms(effect: str, held_out: HeldOut, left: float) -> Iterator[str]:
    """What free curves in the place of the base model's forms leave without and with an effect."""
    before, after = held_out.before.rms[DISPLACEMENT], held_out.after.rms[DISPLACEMENT]
    yield (
        f"Free curves in the place of the base model's forms, of the order over the temperature and of the strain over "
        f"the displacement, do not replace {effect}: on {_on(held_out)} they leave {before:.2f} × the noise of the "
        f"displacement without it, {after:.2f} with it."
    )
    if left > BEYOND:
        yield "The forms of the base model are wrong as well: `lce discover` looks for better ones."


def _named(step: Step) -> str:
    """What is missing, and what data left out say of it."""
    told = outcome(step.held_out, "", _deciding(step.trial))
    return f"{step.added} is missing: {step.trial.effect.meaning}; {told}"


def _deciding(trial: Trial) -> list[Channel]:
    """The sensors that an effect was judged on."""
    return [c for c in trial.stage.channels if c is not untouched_by(trial.effect)]


def _gets_worse(step: Step) -> Iterator[str]:
    """Which sensors that did not decide are explained worse with the effect, on data left out."""
    before, after = step.held_out.before, step.held_out.after
    deciding = _deciding(step.trial)
    for channel in (c for c in before.total if c not in deciding):
        if after.mean_square(channel) > max(RISES * before.mean_square(channel), NOISE):
            judged = " and the ".join(c.name for c in deciding)
            yield f"The {channel.name} is explained worse with it; the effect was judged on the {judged}."


def _since(step: Step) -> Iterator[str]:
    """From when on an effect acts that begins at a time of its own."""
    effect, model = step.trial.effect, step.with_it.model
    for name in effect.in_durations:
        value = model.values[model.index(effect.strength_key)]
        unit = after_number(value.unit)
        at_s = model[f"{effect.name}.{name}"]
        yield f"From {_clock(at_s)} on, {value.parameter.description} is {value.value:.3g}{unit}."


def _clock(time_s: float) -> str:
    """A time as people say it: 42 s, 12 min 5 s, 3 h 12 min."""
    minutes, seconds = divmod(round(time_s), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {seconds} s" if minutes else f"{time_s:.3g} s"


def _stage_at_fault(found: Diagnosis) -> Iterator[str]:
    """Which part of the model left its sensor unexplained, and what that meant for the other."""
    left = f"before anything was added, the model left {_levels(found.train.misfit['before'])}."
    if found.at_fault is None:
        yield left[0].upper() + left[1:]
    else:
        yield f"At fault is {PARTS[found.at_fault]}: {left}"
    if found.drive == "measured":
        yield "The heat does not explain the temperature, so the measured one, smoothed, drove the deformation."
    elif found.apart == "fails":
        yield (
            "The heat does not explain the temperature, so it was fitted alone; not every run has a measured one that "
            "could drive the deformation instead."
        )
    elif found.apart == "bent":
        yield (
            "Fitted together with the displacement the temperature would be explained worse, so the heat was fitted "
            "alone."
        )


def _left_out(found: Diagnosis) -> Iterator[str]:
    """What was left out where no run was held out, or none that shows a sensor."""
    tried = [c.trial.held_out for c in found.candidates if c.trial is not None]
    judged = [h for h in (*tried, *(accepted.held_out for accepted in found.accepted)) if h is not None]
    if not found.held_out:
        yield f"No run was held out{_instead(judged)}. Give one with --test."
        return
    shown = found.test.misfit["after"].total
    for channel in (c for c in found.train.misfit["after"].total if c not in shown):
        instead = _instead([h for h in judged if channel in h.before.total])
        yield f"The runs held out show no {channel.name}{instead}. Give one that does with --test."


def _instead(judged: Sequence[HeldOut]) -> str:
    """What was left out in turn to judge effects; nothing if none was judged so."""
    how = {held_out.how for held_out in judged}
    runs, blocks = "each run in turn" in how, "each block in turn" in how
    if not (runs or blocks):
        return ""
    what = "each run, or blocks of each run," if runs and blocks else "each run" if runs else "each block of every run"
    return f": instead, {what} was left out in turn"


def _levels(misfit: Misfit) -> str:
    return " and ".join(f"{rms:.2f} × the noise in the {c.name}" for c, rms in misfit.rms.items())


def _told(found: Diagnosis) -> dict[Channel, float]:
    """What a model is wrong by, of the sensors that it leaves clearly beyond their noise, which is an estimate."""
    rms = found.train.misfit["after"].rms
    return {channel: value for channel, value in found.discrepancy.items() if rms[channel] > BEYOND}


def _amounts(discrepancy: Mapping[Channel, float]) -> str:
    """Differences as people say them: 0.21 K, 8.53 µm."""
    return " and ".join(
        f"{value * c.difference.factor:.{c.digits}g} {c.difference.symbol}"
        for c, value in discrepancy.items()
        if value > 0.0
    )
