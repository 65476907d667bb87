# SPDX-License-Identifier: Apache-2.0
"""The answer of a diagnosis: verdict, additions, candidates, errors before and after, and what is left."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.metrics import nrmse
from lce_analysis.diagnosis.score_test import Score
from lce_analysis.diagnosis.search import ALIAS_CORRELATION, Search, Step
from lce_analysis.diagnosis.structure import Dependence, dependences, in_words, unlike_noise
from lce_analysis.prediction import CAMERA, DISTANCE, predict
from lce_data.progress import Progress, silent
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect, library

Floats = NDArray[np.float64]
Verdict = Literal["adequate", "missing", "unexplained", "cannot_tell"]
Errors = Mapping[str, float | None]


@dataclass(frozen=True)
class Diagnosis:
    """What is missing, and how that was found.

    before, model : refitted to the runs without any addition, and with what was accepted.
    steps : the additions in their order; scores : of the first examination, one per effect of the library.
    aliases : for each effect, those that look like it in these data.
    runs : how many it was found from.
    rest : what the residual still depends on, strongest first.
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
                    "predicted_fall": s.predicted_fall,
                    "actual_fall": s.actual_fall,
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
                    "predicted_fall": s.predicted_fall,
                    "aliases": list(self.aliases[s.effect.name]),
                }
                for s in self.scores
            ],
            "error": self.error,
            "noise_floor": self.noise_floor,
            "fingerprint": self.fingerprint,
            "seconds": self.seconds,
        }


def diagnose(
    model: Model,
    runs: Sequence[Run],
    test_runs: Sequence[Run] = (),
    effects: Sequence[Effect] | None = None,
    progress: Progress = silent,
) -> Diagnosis:
    """Find the physical effect that ``model`` lacks to explain ``runs``.

    Parameters
    ----------
    model : identified from these or like runs (``lce fit``); it is refitted to all of them together.
    test_runs : held out; only the errors before and after are computed on them.
    effects : candidates, the library where None; those that the model already has are left out.

    LceError where the runs do not hold what the model needs. A KeyboardInterrupt passes through.
    """
    began = perf_counter()
    candidates = library().values() if effects is None else effects
    search = Search(model, runs, [e for e in candidates if e.reference not in model.effects], progress)
    search.forward()
    search.backward()
    left, floor = search.settled.table[-1], search.seen.noise
    rest = dependences(search.problem, left)
    fingerprint = in_words(rest, unlike_noise(search.problem, left, floor))
    scores, before, after = search.first.scores, search.before, search.model()
    return Diagnosis(
        verdict=_verdict(bool(fingerprint), bool(search.steps), bool(search.doubtful)),
        before=before,
        model=after,
        steps=tuple(search.steps),
        scores=tuple(scores),
        aliases={
            s.effect.name: tuple(
                o.effect.name
                for o in scores
                if o is not s and search.first.collinearity(s, o.effect.name) >= ALIAS_CORRELATION
            )
            for s in scores
        },
        rest=tuple(rest),
        fingerprint=fingerprint,
        error={
            name: {"before": errors(before, members), "after": errors(after, members)}
            for name, members in (("train", runs), ("test", test_runs))
        },
        noise_floor={
            key: floor[column].rms if column in floor else None
            for key, column in (("temperature_c", CAMERA), ("displacement_m", DISTANCE))
        },
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
    """NRMSE over all the runs together; None where nothing was measured."""
    found: dict[str, tuple[list[Floats], list[Floats]]] = {
        "temperature_nrmse": ([], []),
        "displacement_nrmse": ([], []),
    }
    for run in runs:
        prediction = predict(model, run)
        for key, series, modelled in (
            ("temperature_nrmse", run.temperature, prediction.temperature_at_samples_k),
            ("displacement_nrmse", run.displacement, prediction.displacement_at_samples_m),
        ):
            if series is not None and modelled is not None:
                found[key][0].append(modelled)
                found[key][1].append(series.value)
    return {key: nrmse(np.concatenate(a), np.concatenate(b)) if a else None for key, (a, b) in found.items()}


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
    told = f"{name} is missing: with it the squared error falls by {step.actual_fall:.0%}"
    told += f" ({step.predicted_fall:.0%} was predicted before the refit)."
    if others:
        told += f" These data cannot tell it from {', '.join(others)}; `lce design` finds the experiment that would."
    return told
