# SPDX-License-Identifier: Apache-2.0
"""One ranking of the candidates, sorted by what decides, each with its reason in plain words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from lce_analysis.diagnosis.accepted import Step
from lce_analysis.diagnosis.score import Score
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.strength import Estimate
from lce_analysis.diagnosis.trial import Objection, Trial
from lce_model.effects import Effect
from lce_model.terms import Parameter

Standing = Literal["missing", "trace", "rejected", "not tried"]
"""Worth having; significant, but not worth having; refitted and refused; not among the few that promised most."""

REASON: Final[Mapping[Objection, str]] = {
    "": "nothing speaks against it, but another effect explains more",
    "less": "others explain more",
    "part": "it removes a part of the error; too much above the noise is left to name it",
    "resembles": "what it leaves still has its shape: it is much like what is missing, and not the same",
    "hidden": "free curves in the place of the base model's forms bring it out; as they are, these hide it",
    "form": "a free curve beside it explains what it leaves: another form is missing, or the base model is wrong there",
    "bound": "a parameter of it is at its bound: it may stand in for something else, or the bound is too narrow",
    "long": "a time constant of it is longer than the runs, which show no end of it: another slow effect may be there",
    "null": "refitted, its strength stays within 0.1 % of its range of its null value, or the error does not fall",
    "chance": "the error falls no more than errors that last for seconds may let it fall by chance",
    "masked": "the free parameters of the model can do the same",
    "worse": "an error rises, or the error in the runs does not fall",
    "small": "it removes too little of the error on data left out",
    "varies": "its strength is not clear of its null value, or the runs want another one",
    "driven": "driven by its own temperature, the model as given explains the displacement better without it",
    "disturbed": "most of its gain is what a sensor or a disturbance from outside did",
    "base": "another base model does as well or better without it",
}
TRACES: Final = frozenset[Objection]({"small", "part", "resembles", "form", "bound", "long", "hidden"})


@dataclass(frozen=True)
class Candidate:
    """An effect of the library and what became of it.

    score : the score test that led to its trial, or the last one.
    trial : its refit; None if it was not tried.
    standing, reason : the outcome, and why, in words.
    aliases : effects that look like it in these data.
    """

    score: Score
    trial: Trial | None
    standing: Standing
    reason: str
    aliases: tuple[str, ...]

    @property
    def effect(self) -> Effect:
        """Which effect."""
        return self.score.effect

    @property
    def predicted_reduction(self) -> float:
        """Share of the error above the noise that the score test promised."""
        return self.score.predicted_reduction

    @property
    def actual_reduction(self) -> float | None:
        """The share that went in the refit; None if there was none."""
        return None if self.trial is None else self.trial.reduction

    @property
    def amplitude(self) -> Parameter:
        """The parameter whose value is reported as the strength."""
        return self.effect.parameter(self.effect.strength) if self.trial is None else self.trial.amplitude

    @property
    def strength(self) -> Estimate | None:
        """As refitted."""
        return None if self.trial is None or self.trial.strengths is None else self.trial.strengths.overall

    @property
    def settings(self) -> Mapping[str, float]:
        """TERM.PARAM to value of all its parameters: as refitted, or as the score test expects them."""
        if self.trial is None:
            return self.score.settings_at_expected_strength
        own = self.trial.fit.problem.model.values
        return {v.key: v.value for v in own if v.term == self.effect.name and not v.parameter.fixed}


def ranking(search: Search) -> tuple[Candidate, ...]:
    """Every candidate once: what was accepted, what was tried by its gain, then the rest by what it promised."""
    accepted = {step.added: step for step in search.steps}
    found = [_candidate(search, name, score, accepted.get(name)) for name, score in search.trials.scores.items()]
    order = list(accepted)

    def key(c: Candidate) -> tuple[float, float]:
        if c.effect.name in accepted:
            return 0.0, float(order.index(c.effect.name))
        return (1.0, -c.trial.gain) if c.trial else (2.0, -c.score.predicted_gain)

    return tuple(sorted(found, key=key))


def _candidate(search: Search, name: str, score: Score, step: Step | None) -> Candidate:
    aliases = search.trials.aliases.get(name, ())
    if step is not None:
        return Candidate(step.trial.score, step.trial, "missing", "worth having", aliases)
    trial = search.trials.tried.get(name)
    if trial is None:
        why = f"it promised too little for a refit, or less than those that were tried{_at_default_only(score.effect)}"
        return Candidate(score, None, "not tried", why, aliases)
    standing: Standing = "trace" if trial.objection in TRACES else "rejected"
    return Candidate(trial.score, trial, standing, reason(trial.effect, trial.objection), aliases)


def reason(effect: Effect, objection: Objection) -> str:
    """Why a trial ended as it did."""
    return REASON[objection] + (_at_default_only(effect) if objection == "null" else "")


def _at_default_only(effect: Effect) -> str:
    """Where the strength of a user's own effect stays at zero: the parameters that no grid has tried out."""
    values = [f"{name} = {effect.parameter(name).default:g}" for name in effect.at_default_only]
    if not (effect.path and values):
        return ""
    return f"; it was looked for at {' and '.join(values)} only, give `grid` in {Path(effect.path).name} values to try"


def traces(candidates: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Significant, and not worth having."""
    return tuple(c for c in candidates if c.standing == "trace")
