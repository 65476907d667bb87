# SPDX-License-Identifier: Apache-2.0
"""The answer of a diagnosis: verdict, additions, candidates, errors before and after, and what is left."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.metrics import nrmse
from lce_analysis.diagnosis.score import Score
from lce_analysis.diagnosis.search import Search, Step
from lce_analysis.diagnosis.structure import Dependence, dependences, in_words, unlike_noise
from lce_analysis.options import DiagnoseOptions
from lce_analysis.prediction import predict
from lce_data.channels import SENSORS, Channel
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect, library

Floats = NDArray[np.float64]
Verdict = Literal["adequate", "missing", "unexplained", "cannot_tell"]
Errors = Mapping[str, float | None]


@dataclass(frozen=True)
class Diagnosis:
    """What is missing, and how that was found.

    Attributes
    ----------
    verdict : "adequate" (nothing is missing), "missing" (effects of the library were added), "unexplained" (something
        is left that no effect of the library explains) or "cannot_tell".
    before, model : refitted to the runs without any addition, and with what was accepted.
    steps : the additions in their order.
    scores : of the first score test, one per effect of the library, strongest evidence first.
    aliases : for each effect, those that look like it in these data.
    rest : what the residual still depends on, strongest first.
    fingerprint : what is left, in words; empty if it is noise.
    noise_floor : RMS noise of each sensor, key and unit as a column of a CSV ("temperature_c", "displacement_m"); None
        if it was not measured.
    runs : number of runs that it was found from.
    seconds : how long it took [s].
    error : NRMSE {"train" | "test": {"before" | "after": {"temperature_nrmse": …, "displacement_nrmse": …}}}.
    """

    verdict: Verdict
    before: Model
    model: Model
    steps: tuple[Step, ...]
    scores: tuple[Score, ...]
    aliases: Mapping[str, tuple[str, ...]]
    rest: tuple[Dependence, ...]
    fingerprint: str
    error: Mapping[str, Mapping[str, Errors]]
    noise_floor: Errors
    runs: int
    seconds: float

    @property
    def sentences(self) -> tuple[str, ...]:
        """The answer in words, the verdict first."""
        return tuple(_in_words(self))

    def as_json(self) -> dict[str, Any]:
        """The contract's record: all keys always there, numbers in SI or °C."""
        return {
            "verdict": self.verdict,
            "added": [s.added for s in self.steps],
            "steps": [
                {
                    "added": s.added,
                    "set": list(s.alias_set),
                    "predicted_fall": s.predicted_reduction,
                    "actual_fall": s.actual_reduction,
                }
                for s in self.steps
            ],
            "candidates": [
                {
                    "effect": s.effect.name,
                    "stage": s.effect.stage,
                    "evidence": s.evidence,
                    "p_value": s.p_value,
                    "visibility": s.visibility,
                    "expected_strength": s.expected_strength,
                    "predicted_fall": s.predicted_reduction,
                    "aliases": list(self.aliases[s.effect.name]),
                }
                for s in self.scores
            ],
            "error": self.error,
            "noise_floor": self.noise_floor,
            "fingerprint": self.fingerprint,
            "seconds": self.seconds,
        }

    def as_detailed_json(self) -> dict[str, Any]:
        """The record of :meth:`as_json` with what a page draws from.

        Returns
        -------
        dict
            Also "sentences", and for each candidate "settings" (TERM.PARAM to value at its expected strength) and
            "shown" (would these data show it at some strength within its bounds?).
        """
        record = self.as_json()
        candidates = [
            {**candidate, "settings": dict(score.settings_at_expected_strength), "shown": score.shown}
            for candidate, score in zip(record["candidates"], self.scores, strict=True)
        ]
        return {**record, "candidates": candidates, "sentences": list(self.sentences)}


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
    test_runs : held out; only the errors before and after are computed on them.
    effects : candidates, the whole library if None; those that the model already has are left out.
    options : when an effect counts as missing.
    progress : called after each step.
    cancel : stops between two steps and raises Cancelled.

    Returns
    -------
    Diagnosis
        Verdict, effects added, the score of every candidate, and the errors before and after.

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
    search = Search(model, runs, missing, options, watched(progress, cancel))
    search.forward()
    search.backward()
    left, floor = search.fit.table[-1], search.score_tests.noise
    rest = dependences(search.problem, left, options)
    fingerprint = in_words(rest, unlike_noise(search.problem, left, floor, options), options)
    first, before, after = search.first_score_tests, search.before, search.model()
    return Diagnosis(
        verdict=_verdict(bool(fingerprint), bool(search.steps), bool(search.doubtful)),
        before=before,
        model=after,
        steps=tuple(search.steps),
        scores=tuple(first.scores),
        aliases={
            s.effect.name: tuple(
                o.effect.name
                for o in first.scores
                if o is not s and first.collinearity(s, o.effect.name) >= options.alias_correlation
            )
            for s in first.scores
        },
        rest=tuple(rest),
        fingerprint=fingerprint,
        error={
            name: {"before": errors(before, members), "after": errors(after, members)}
            for name, members in (("train", runs), ("test", test_runs))
        },
        noise_floor={channel.column: floor[channel].rms if channel in floor else None for channel in SENSORS},
        runs=len(runs),
        seconds=perf_counter() - began,
    )


def _verdict(structured: bool, added: bool, doubtful: bool) -> Verdict:
    """In the order of what can be said: something unexplained, missing, doubtful, or nothing."""
    if structured:
        return "unexplained"
    if added:
        return "missing"
    return "cannot_tell" if doubtful else "adequate"


def errors(model: Model, runs: Sequence[Run]) -> Errors:
    """NRMSE over all the runs together; None for a channel that was not measured."""
    modelled: dict[Channel, list[Floats]] = {channel: [] for channel in SENSORS}
    measured: dict[Channel, list[Floats]] = {channel: [] for channel in SENSORS}
    for run in runs:
        for channel, values in predict(model, run).at_samples.items():
            modelled[channel].append(values)
            measured[channel].append(run.series[channel].value)
    return {
        f"{channel.name}_nrmse": nrmse(np.concatenate(values), np.concatenate(measured[channel])) if values else None
        for channel, values in modelled.items()
    }


def _in_words(found: Diagnosis) -> list[str]:
    words = [_step_in_words(s) for s in found.steps]
    if found.verdict == "adequate":
        words.append("Nothing is missing: no effect of the library improves the model beyond chance.")
    if found.verdict == "unexplained":
        words.insert(0, f"Something is missing that the library does not hold: {found.fingerprint}.")
    if found.verdict == "cannot_tell":
        words.append(
            "Something may be missing, but these data cannot tell what: the effects that would help are masked by the "
            "free parameters, or fail on runs left out."
        )
    if found.steps and found.runs == 1:
        words.append("There is only one run, so nothing was confirmed on a run left out.")
    masked = [s.effect.name for s in found.scores if not s.shown]
    if masked and found.verdict != "unexplained":
        words.append(f"These data would not show, at any strength within its bounds: {', '.join(masked)}.")
    return words


def _step_in_words(step: Step) -> str:
    name, *others = step.alias_set
    words = f"{name} is missing: with it the squared error falls by {step.actual_reduction:.0%}"
    words += f" ({step.predicted_reduction:.0%} was predicted before the refit)."
    if others:
        words += f" These data cannot tell it from {', '.join(others)}; `lce design` finds the experiment that would."
    return words
