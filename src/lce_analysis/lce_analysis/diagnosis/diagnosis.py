# SPDX-License-Identifier: Apache-2.0
"""The answer of a diagnosis: verdict, what was added and why, the error in three columns, and what is left."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.metrics import nrmse
from lce_analysis.diagnosis.accepted import Accepted, Step, VariationStep
from lce_analysis.diagnosis.disturbed import signatures_left
from lce_analysis.diagnosis.free_forms import name_behind_wrong_forms
from lce_analysis.diagnosis.held_out import HeldOut
from lce_analysis.diagnosis.looking_back import take_back_refuted
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit
from lce_analysis.diagnosis.other_base import OtherBase, OtherBases, deformation_steps
from lce_analysis.diagnosis.ranking import Candidate, ranking, traces
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.stage_problem import Apart, Part
from lce_analysis.diagnosis.strength import Estimate
from lce_analysis.diagnosis.structure import Dependence, left_over
from lce_analysis.diagnosis.trial import Objection, Trial
from lce_analysis.diagnosis.words import in_words
from lce_analysis.identification.at_bounds import AtBound, at_bounds
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.inputs import lacks
from lce_analysis.options import DiagnoseOptions, Drive
from lce_analysis.prediction import predict, says_nothing
from lce_analysis.signatures import Signature
from lce_data.channels import SENSORS, TEMPERATURE, Channel
from lce_data.noise import sensor_noise
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model, RunValue, Variation
from lce_model.effects import Effect, library

Floats = NDArray[np.float64]
Verdict = Literal["adequate", "missing", "unexplained", "cannot_tell"]
Column = Literal["given", "before", "after"]
"""The model as given, the same refitted, and with what was added."""
Errors = Mapping[str, float | None]
EVENT: Final = "it begins at a time of its own, and several runs do not share one"
DOUBTFUL: Final = frozenset[Objection]({"masked", "varies", "chance", "worse", "resembles", "bound", "long"})
"""What leaves open whether the effect is there."""


@dataclass(frozen=True)
class ErrorTable:
    """Errors of three models on the runs that they were refitted to, and on those held out.

    misfit : by column, in units of the sensors' noise; nrmse : by column, as in `lce compare`.
    """

    misfit: Mapping[Column, Misfit]
    nrmse: Mapping[Column, Errors]


@dataclass(frozen=True)
class Diagnosis:
    """What is missing, and how that was found.

    Attributes
    ----------
    verdict : "adequate" (nothing is missing), "missing" (effects of the library are worth adding), "unexplained"
        (something is left that no effect of the library explains) or "cannot_tell".
    given, before, model : as given, refitted to the runs without any addition, and with what was accepted.
    at_fault : the part of the model that left a sensor unexplained before anything was added, or of which an effect
        is missing; None if none did.
    apart : why the heat was fitted alone in the end, as of ``StagedFit``.
    drive : what drove the deformation when it was judged.
    accepted : what was changed in the model, in its order: ``steps`` are the effects that were added, ``variations``
        the parameters that were found to differ from run to run.
    free_forms : of effects that no form of the base model replaces, by name, the errors of data left out without and
        with them beside free curves in the place of these forms.
    candidates : one per effect that was examined, sorted by what decides.
    not_examined : the effects that are no candidates beside these runs, and why, in words.
    at_bounds : parameters that the final model has at a bound; not looked for where nothing is missing.
    held_back : by name of the effect, parameters of candidates at a bound beyond which these explain more.
    rest : what the residual still depends on, strongest first.
    signatures : what the residual of the final model shows, strongest first.
    fingerprint : what is left, in words; empty unless the verdict is "unexplained".
    other_base : a base model that explains the displacement better, with what it lacks; None if none was found.
    train, test : the errors of the three models.
    away_from_jumps : of the final model beside ``runs``, on the samples away from jumps of the displacement.
    noise : RMS noise [SI] of each sensor.
    discrepancy : RMS [SI] of what the final model leaves beyond the noise of each sensor.
    runs : names of the runs that it was found from, and `held_out` of those that were held out.
    seconds : how long it took [s].
    """

    verdict: Verdict
    given: Model
    before: Model
    model: Model
    at_fault: Part | None
    apart: Apart
    drive: Drive
    accepted: tuple[Accepted, ...]
    free_forms: Mapping[str, HeldOut]
    candidates: tuple[Candidate, ...]
    not_examined: Mapping[str, str]
    at_bounds: tuple[AtBound, ...]
    held_back: Mapping[str, tuple[AtBound, ...]]
    rest: tuple[Dependence, ...]
    signatures: tuple[Signature, ...]
    fingerprint: str
    other_base: OtherBase | None
    train: ErrorTable
    test: ErrorTable
    away_from_jumps: Misfit
    noise: Mapping[Channel, float]
    discrepancy: Mapping[Channel, float]
    runs: tuple[str, ...]
    held_out: tuple[str, ...]
    seconds: float

    @property
    def steps(self) -> tuple[Step, ...]:
        """The effects that were added, in their order."""
        return tuple(a for a in self.accepted if isinstance(a, Step))

    @property
    def variations(self) -> tuple[VariationStep, ...]:
        """The parameters that were found to differ from run to run, in their order."""
        return tuple(a for a in self.accepted if isinstance(a, VariationStep))

    @property
    def traces(self) -> tuple[Candidate, ...]:
        """Effects that are significant and not worth having."""
        return traces(self.candidates)

    @property
    def sentences(self) -> tuple[str, ...]:
        """The answer in words: the verdict, after what a sensor or a disturbance did and which base model is better."""
        return tuple(in_words(self))

    def as_json(self) -> dict[str, Any]:
        """The contract's record: all keys always there, numbers in SI or °C."""
        tables = {"train": self.train, "test": self.test}
        return {
            "verdict": self.verdict,
            "added": [s.added for s in self.steps],
            "steps": [_step_json(s, self.runs) for s in self.steps],
            "candidates": [_candidate_json(c) for c in self.candidates],
            "traces": [_candidate_json(c) for c in self.traces],
            "error": {name: dict(table.nrmse) for name, table in tables.items()},
            "error_over_noise": {
                name: {column: _over_noise(misfit) for column, misfit in table.misfit.items()}
                for name, table in tables.items()
            },
            "away_from_jumps": _over_noise(self.away_from_jumps),
            "noise_floor": {channel.column: self.noise.get(channel) for channel in SENSORS},
            "discrepancy": {channel.column: self.discrepancy.get(channel) for channel in SENSORS},
            "varies": {key: _by_run_json(variation) for key, variation in self.model.varies.items()},
            "signatures": [one.as_json() for one in self.signatures],
            "fingerprint": self.fingerprint,
            "free_forms": {name: _held_out_json(found) for name, found in self.free_forms.items()},
            "other_base": None if self.other_base is None else self.other_base.as_json(),
            "seconds": self.seconds,
        }

    def as_detailed_json(self) -> dict[str, Any]:
        """The record of :meth:`as_json` with what a page draws from.

        Returns
        -------
        dict
            Also "sentences", and for each candidate "settings" (TERM.PARAM to value at its strength), "meaning" (what
            the effect does, in one line) and "shown" (would these data show it at some strength within its bounds?).
        """
        record = self.as_json()
        candidates = [
            {**of_contract, "settings": dict(c.settings), "meaning": c.effect.meaning, "shown": c.score.shown}
            for of_contract, c in zip(record["candidates"], self.candidates, strict=True)
        ]
        return {**record, "candidates": candidates, "sentences": list(self.sentences)}


def _step_json(step: Step, runs: Sequence[str]) -> dict[str, Any]:
    by_run = dict(zip(runs, step.trial.strengths.by_run, strict=True)) if step.trial.strengths else {}
    return {
        "added": step.added,
        "set": list(step.alias_set),
        "predicted_fall": step.predicted_reduction,
        "actual_fall": step.actual_reduction,
        "strength_of": f"{step.added}.{step.trial.amplitude.name}",
        "strength_by_run": {name: None if e is None else _estimate_json(e) for name, e in by_run.items()},
        "left_out": step.held_out.how,
        "held_out": _held_out_json(step.held_out),
    }


def _estimate_json(found: Estimate | RunValue) -> list[float | None]:
    """Value and standard error; JSON knows no infinity, so an error that is undetermined is null."""
    error = found.standard_error
    return [found.value, error if error is not None and math.isfinite(error) else None]


def _by_run_json(variation: Variation) -> dict[str, list[float | None]]:
    return {name: _estimate_json(own) for name, own in variation.by_run.items()}


def _candidate_json(c: Candidate) -> dict[str, Any]:
    held_out = c.trial.held_out if c.trial else None
    return {
        "effect": c.effect.name,
        "stage": c.effect.stage,
        "standing": c.standing,
        "reason": c.reason,
        "evidence": c.score.evidence,
        "p_value": c.score.p_value,
        "visibility": c.score.visibility,
        "expected_strength": c.score.expected_strength,
        "expected_strength_of": f"{c.effect.name}.{c.score.direction.amplitude.name}",
        "predicted_fall": c.predicted_reduction,
        "actual_fall": c.actual_reduction,
        "strength": None if c.strength is None else _estimate_json(c.strength),
        "strength_of": f"{c.effect.name}.{c.amplitude.name}",
        "held_out": None if held_out is None else _held_out_json(held_out),
        "aliases": list(c.aliases),
    }


def _held_out_json(found: HeldOut) -> dict[str, dict[str, float | None]]:
    return {"before": _over_noise(found.before), "after": _over_noise(found.after)}


def _over_noise(misfit: Misfit) -> dict[str, float | None]:
    rms = misfit.rms
    return {channel.name: rms.get(channel) for channel in SENSORS}


def diagnose(
    model: Model,
    runs: Sequence[Run],
    test_runs: Sequence[Run] = (),
    effects: Sequence[Effect] | None = None,
    options: DiagnoseOptions = DiagnoseOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Diagnosis:
    """Find the physical effect that a model lacks to explain runs.

    Parameters
    ----------
    model : identified from these or like runs (:func:`fit`); it is refitted to all of them together.
    runs : what the model is to explain.
    test_runs : held out; they decide whether an effect is worth having. Without them each run is left out in turn,
        or, with one run or with values of its own for each, each fifth of every run.
    effects : candidates, the whole library if None; those that the model already has are left out.
    options : when an effect counts as missing.
    progress : called after each step.
    cancel : stops between two steps and raises Cancelled.

    Returns
    -------
    Diagnosis
        Verdict, effects added, one ranking of the candidates, and the errors of the model as given, refitted, and with
        what was added.

    Raises
    ------
    LceError
        If the runs do not hold what the model needs.

    Examples
    --------
    >>> import lce_analysis as lce
    >>> found = lce.diagnose(model, runs, test_runs)  # doctest: +SKIP
    >>> print(found.verdict, [step.added for step in found.steps])  # doctest: +SKIP
    """
    began = perf_counter()
    candidates = library().values() if effects is None else effects
    missing = [e for e in candidates if e.reference not in model.effects]
    not_examined = {e.name: why for e in missing if (why := _not_examined(e, runs, test_runs))}
    missing = [e for e in missing if e.name not in not_examined]
    search = Search(model, runs, test_runs, missing, options, watched(progress, cancel))
    bases = OtherBases(search)
    search.run(bases.explain)
    other_base = compared_bases(search, bases)
    if other_base is None:
        name_behind_wrong_forms(search)
    signatures = signatures_left(search)
    rest, fingerprint = left_over(search.present, signatures, options)
    models = columns(search, model)
    verdict = _verdict(search)
    train = error_table(search, models, search.data.judged)
    noise = sensor_noise(runs, SENSORS)
    after = train.misfit["after"]
    return Diagnosis(
        verdict=verdict,
        given=model,
        before=search.base.model,
        model=search.present.model.varying(search.varies()),
        at_fault=_at_fault(search),
        apart=search.present.apart,
        drive=search.present.drive,
        accepted=tuple(search.accepted),
        free_forms=search.free_forms,
        candidates=ranking(search),
        not_examined=not_examined,
        at_bounds=() if verdict == "adequate" else bounds_reached(search),
        held_back={} if verdict == "adequate" else _held_back(search),
        rest=rest,
        signatures=signatures,
        fingerprint=fingerprint if verdict == "unexplained" else "",
        other_base=other_base,
        train=train,
        test=error_table(search, models, search.tests),
        away_from_jumps=search.data.judged.away_from_jumps(search.whole(search.present.model), search.present.drive),
        noise=noise,
        discrepancy={c: float(np.sqrt(after.above_noise(c))) * noise[c] for c in after.total},
        runs=tuple(run.name for run in runs),
        held_out=tuple(run.name for run in test_runs),
        seconds=perf_counter() - began,
    )


def _not_examined(effect: Effect, runs: Sequence[Run], test_runs: Sequence[Run]) -> str:
    """Why an effect is no candidate beside these runs; empty if it is one."""
    every = [*runs, *test_runs]
    return EVENT if effect.in_durations and len(every) > 1 else lacks(effect, every)


def compared_bases(search: Search, bases: OtherBases) -> OtherBase | None:
    """A base model that does better; then the effects of the deformation beside the present one are taken back."""
    found = bases.better()
    behind = deformation_steps(search)
    if found is not None and behind:
        for step in reversed(behind):
            search.drop(step, "base")
        search.finish()
        take_back_refuted(search)
    return found


def _verdict(search: Search) -> Verdict:
    """Worth adding; else nothing is left; else something that an effect might be, or none of the library."""
    if search.steps:
        return "missing"
    if search.present.worst <= search.options.explained:
        return "adequate"
    left = {channel for channel, x in search.present.mean_squares.items() if x > search.options.explained**2}
    open_trials = [t for t in search.trials.tried.values() if left & set(t.stage.channels)]
    return "cannot_tell" if any(_doubtful(t, search.options) for t in open_trials) else "unexplained"


def _doubtful(trial: Trial, options: DiagnoseOptions) -> bool:
    """Might the effect be there? It explains the runs, but something stands against it, as data left out may."""
    if trial.objection == "hidden":
        return True
    if trial.objection == "part":
        return trial.reduction >= options.nearly_all
    return trial.objection in DOUBTFUL and trial.reduction >= options.most


def _at_fault(search: Search) -> Part | None:
    """The part of the model behind the sensors that are beyond their noise; None where these do not tell the part.

    An effect of the heat may be missing although the temperature alone does not show it.
    """
    base = search.base
    beyond = {channel for channel, x in base.mean_squares.items() if x > search.options.explained**2}
    stage = base.deformation
    heat_unseen = stage is not None and not base.heat and not any(i.driven for i in stage.fit.problem.inputs)
    if not beyond or heat_unseen:
        return None
    heat = TEMPERATURE in beyond or any(acts_on_temperature(step.trial.effect) for step in search.steps)
    return ("heat" if beyond == {TEMPERATURE} else "both") if heat else "deformation"


def bounds_reached(search: Search) -> tuple[AtBound, ...]:
    """Of the parameters of all stages; the part that has the last word on a parameter knows its bound."""
    stages = [p for p in (*search.present.heat[:1], search.present.deformation) if p is not None]
    found: dict[str, AtBound] = {}
    for problem in (stage.fit.problem for stage in stages):
        for key in (problem.model.values[i].key for i in problem.free):
            found.pop(key, None)
        found |= {bound.key: bound for bound in at_bounds(problem, search.progress)}
    return tuple(found.values())


def _held_back(search: Search) -> dict[str, tuple[AtBound, ...]]:
    """Of the effects that were refused at a bound, what they gain beyond it."""
    found = {}
    for name, trial in search.trials.tried.items():
        if trial.objection == "bound":
            own = at_bounds(trial.fit.problem, search.progress, term=name)
            found[name] = tuple(bound for bound in own if bound.wanted is not None)
    return found


def columns(search: Search, given: Model) -> Mapping[Column, Model]:
    """The three models that every table compares."""
    return {"given": given, "before": search.base.model, "after": search.present.model}


def error_table(search: Search, models: Mapping[Column, Model], judged: JudgedRuns) -> ErrorTable:
    """Errors of the three models, simulated beside some runs."""
    drive = search.present.drive
    return ErrorTable(
        {column: search.misfit(model, drive, judged) for column, model in models.items()},
        {column: errors(search.whole(model), judged.runs, drive) for column, model in models.items()},
    )


def errors(model: Model, runs: Sequence[Run], drive: Drive = "model") -> Errors:
    """NRMSE over all the runs together; None for a channel that was not measured, or never changes."""
    modelled: dict[Channel, list[Floats]] = {channel: [] for channel in SENSORS}
    measured: dict[Channel, list[Floats]] = {channel: [] for channel in SENSORS}
    for run in runs:
        if says_nothing(run, model):
            continue
        for channel, values in predict(model, run, drive).at_samples.items():
            modelled[channel].append(values)
            measured[channel].append(run.series[channel].value)
    return {
        f"{channel.name}_nrmse": nrmse(np.concatenate(values), np.concatenate(measured[channel]))
        if values and np.ptp(np.concatenate(measured[channel])) > 0.0
        else None
        for channel, values in modelled.items()
    }
