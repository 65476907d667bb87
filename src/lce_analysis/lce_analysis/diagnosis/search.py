# SPDX-License-Identifier: Apache-2.0
"""Forward and backward through the library: refit the best few, keep what the data confirm.

A candidate is accepted where the penalised likelihood and leave-one-run-out agree. The search ends when nothing more
passes; then every accepted effect has to prove itself once more against the others.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, in_noise, settle
from lce_analysis.diagnosis.score_test import Score, ScoreTestResult, score_test
from lce_analysis.diagnosis.whitening import Noise
from lce_analysis.identification.discontinuities import without_jumps
from lce_analysis.identification.identify import check_runs
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem, observed_series, start_conditions
from lce_analysis.prediction import CAMERA, DISTANCE, simulation_input
from lce_data.errors import LceError
from lce_data.noise import noise_floor
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect

Floats = NDArray[np.float64]

FALSE_ALARM: Final = 0.05
"""Chance of a false addition to a complete model, over the whole library."""
REFITTED: Final = 3
"""Candidates that are refitted in each step: so many by evidence, and so many by the fall that they promise."""
ALIAS_CORRELATION: Final = 0.95
"""|ρ| from which two effects are reported as a set."""
MIN_LIKELIHOOD_RATIO: Final = 20.0
"""Likelihood ratio below which two refitted effects are reported as a set."""
VISIBLE: Final = 1e-4
"""Visibility below which an effect that the data ask for is not named: a small error of the base model's own form
would do as well."""
MOST: Final = 4
"""Effects that are added at most."""
ITERATIONS: Final = 60
"""Of a refit, at most. An effect that the free parameters nearly mask takes some thirty."""


@dataclass(frozen=True)
class Refit:
    """The model refitted with one more effect.

    gain : fall of the squared whitened error; held_out : the same with each run predicted from the others.
    """

    score: Score
    settled: LinearizedFit
    gain: float
    held_out: float

    @property
    def effect(self) -> Effect:
        """Which effect."""
        return self.score.effect


@dataclass(frozen=True)
class Step:
    """One effect accepted: with which it may be confused, and the fall of the error predicted and found."""

    added: str
    alias_set: tuple[str, ...]
    predicted_fall: float
    actual_fall: float


def free_parameters(effect: Effect) -> int:
    """How many parameters the effect adds to a fit."""
    return sum(not p.fixed for p in effect.parameters)


def price(effect: Effect, library: int) -> float:
    """Fall of the squared whitened error (-2 ln L) that the effect must buy: 2 n ln(n_library/p)."""
    return 2.0 * free_parameters(effect) * math.log(library / FALSE_ALARM)


def freed(problem: Problem, effect: Effect) -> Problem:
    """The problem with the parameters of the effect among the free ones."""
    extra = [i for i, v in enumerate(problem.model.values) if v.term == effect.name and not v.parameter.fixed]
    return replace(problem, free=tuple(sorted({*problem.free, *extra})))


def closed(problem: Problem, effect: Effect) -> Problem:
    """The problem with the effect at its null value and its parameters fixed at their defaults."""
    own = {i for i, v in enumerate(problem.model.values) if v.term == effect.name}
    model = problem.model.set({f"{effect.name}.{p.name}": p.default for p in effect.parameters})
    return replace(problem, model=model, free=tuple(i for i in problem.free if i not in own))


def first_step(seen: ScoreTestResult, score: Score) -> Problem:
    """The full model moved to where the linearisation wants it, as far as that helps; one simulation each."""
    base, plain = seen.settled.problem, seen.plain
    base = replace(base, observed=in_noise(base.observed, seen.noise))
    z, effect = base.first(), score.effect
    spec = effect.parameter(effect.strength)
    strength = float(np.clip(plain.strength[score.index], spec.lower - effect.null, spec.upper - effect.null))
    shift = np.clip(plain.solve[:, -1] - strength * plain.solve[:, score.index], -0.3, 0.3)
    best, least = base, math.inf
    for length in (1.0, 0.4, 0.15):
        there = base.at(z + length * shift)
        value = effect.null + length * strength
        there = replace(there, model=there.model.set({**score.direction.settings, effect.strength_key: value}))
        residual = there.residuals(there.first())
        error = float(residual @ residual)
        if error < least:
            best, least = there, error
    return best


class Search:
    """The present model within the full one, and what has been accepted so far."""

    def __init__(self, model: Model, runs: Sequence[Run], candidates: Sequence[Effect], progress: Progress) -> None:
        self.progress, self.candidates = progress, list(candidates)
        self.steps: list[Step] = []
        self.doubtful: list[str] = []
        problem = _problem(model, runs, self.candidates)
        problem = without_jumps(self._as_it_is(problem, _misfit(problem)).problem)
        self.settled = self._as_it_is(problem, _misfit(problem))
        self.seen = self._look(_misfit(self.settled.problem))
        self.first, self.before = self.seen, self.model()

    @property
    def problem(self) -> Problem:
        """The present model beside the data, at its least squares."""
        return self.settled.problem

    def forward(self) -> None:
        """Add effects until nothing passes."""
        while len(self.steps) < MOST and self._add_best():
            self.seen = self._look(self.seen.noise)

    def force(self, effect: Effect) -> bool:
        """Add this effect whatever the data think of it, and say what they think."""
        score = next(s for s in self.seen.by_fall if s.effect.name == effect.name)
        (refit,) = self._refits([score])
        self._accept(refit, [refit])
        return self._passes(refit)

    def backward(self) -> None:
        """Take out what later additions have made superfluous."""
        for step in self.steps[:-1]:
            effect = next(e for e in self.candidates if e.name == step.added)
            label = f"without {effect.name}"
            without = settle(closed(self.problem, effect), self.seen.noise, label, self.progress, ITERATIONS)
            if without.error(self.seen.noise) - self.settled.error(self.seen.noise) < self._price(effect):
                self.steps.remove(step)
                self.settled = without

    def model(self) -> Model:
        """The present model without the effects that were not accepted."""
        return self._stripped(self.problem.model)

    def remaining(self) -> list[Effect]:
        """Effects that have not been accepted."""
        added = {s.added for s in self.steps}
        return [e for e in self.candidates if e.name not in added]

    def _look(self, noise: Mapping[int, Noise]) -> ScoreTestResult:
        """Examine with the noise of the richest fit, settle in units of it, and score_test again."""
        label = "every effect at once"
        self.progress(label, 0, 2, float("nan"))
        noise = score_test(self.settled, self.remaining(), noise, estimate=True).noise
        self.settled = self._as_it_is(self.problem, noise)
        self.progress(label, 1, 2, float("nan"))
        bar = 2.0 * math.log(len(self.candidates) / FALSE_ALARM)
        return score_test(self.settled, self.remaining(), noise, estimate=True, bar=bar)

    def _stripped(self, model: Model) -> Model:
        for effect in self.remaining():
            model = model.without(effect.reference)
        return model

    def _as_it_is(self, problem: Problem, noise: Mapping[int, Noise]) -> LinearizedFit:
        """Least squares without any further effect, in the smaller model, which is several times faster."""
        small = self._stripped(problem.model)
        free = tuple(small.index(problem.model.values[i].key) for i in problem.free)
        found = settle(replace(problem, model=small, free=free), noise, "the model as it is", self.progress, ITERATIONS)
        whole = problem.model.set({v.key: v.value for v in found.problem.model.values})
        return replace(found, problem=replace(found.problem, model=whole, free=problem.free))

    def _price(self, effect: Effect) -> float:
        return price(effect, len(self.candidates))

    def _add_best(self) -> bool:
        likely = [*self.seen.scores[:REFITTED], *self.seen.by_fall[:REFITTED]]
        chosen = {s.effect.name: s for s in reversed(likely) if s.evidence > 0.0 or s.predicted_fall > 0.0}
        refits = self._refits(list(chosen.values()))
        for best in refits:
            if self._passes(best) and best.score.visibility >= VISIBLE:
                self._accept(best, refits)
                return True
            if best.gain > self._price(best.effect):
                self.doubtful.append(best.effect.name)
        return False

    def _refits(self, scores: Sequence[Score]) -> list[Refit]:
        """Least squares of everything with each candidate, the likeliest first.

        All are judged by the noise that the best of them leaves, where that is less than in the richest linear fit.
        """
        noise = self.seen.noise
        starts = [(f"with {s.effect.name}", freed(first_step(self.seen, s), s.effect)) for s in scores]
        tasks = [partial(settle, start, noise, label, iterations=ITERATIONS) for label, start in starts]
        settled = list(each(tasks, "refits", self.progress))
        if not settled:
            return []
        left = min(settled, key=lambda s: s.plain_error(noise)).noise(noise)
        noise = {c: min(left[c], noise[c], key=lambda n: n.rms) for c in noise}
        error, held_out = self.settled.error(noise), float(self.settled.held_out(noise).sum())
        refits = [
            Refit(score, s, error - s.error(noise), held_out - float(s.held_out(noise).sum()))
            for score, s in zip(scores, settled, strict=True)
        ]
        return sorted(refits, key=lambda r: self._price(r.effect) - r.gain)

    def _passes(self, refit: Refit) -> bool:
        return refit.gain > self._price(refit.effect) and refit.held_out > 0.0

    def _accept(self, best: Refit, refits: Sequence[Refit]) -> None:
        noise, settled = self.seen.noise, best.settled
        fall = 1.0 - settled.plain_error(noise) / self.settled.plain_error(noise)
        alias_set = self._alias_set(best, refits)
        self.steps.append(Step(best.effect.name, alias_set, best.score.predicted_fall, fall))
        self.settled = settled

    def _alias_set(self, best: Refit, refits: Sequence[Refit]) -> tuple[str, ...]:
        """The effects that explain the same: refitted nearly as well, or alike in direction and never refitted.

        Alike in direction is not enough where the bounds of the other's strength leave it less than half of the fall.
        """

        def penalised(r: Refit) -> float:
            return self._price(r.effect) - r.gain

        close = [r.effect.name for r in refits if penalised(r) - penalised(best) < 2.0 * math.log(MIN_LIKELIHOOD_RATIO)]
        refitted = {r.effect.name for r in refits}
        alike = [
            s.effect.name
            for s in self.seen.scores
            if s.effect.name not in refitted
            and s.evidence > 0.5 * best.score.evidence
            and self.seen.collinearity(best.score, s.effect.name) >= ALIAS_CORRELATION
        ]
        return tuple(dict.fromkeys([best.effect.name, *close, *alike]))


def _problem(model: Model, runs: Sequence[Run], candidates: Sequence[Effect]) -> Problem:
    """The model, with all candidates at their null values, beside the runs."""
    if not runs:
        raise LceError("no runs to diagnose")
    check_runs(model, runs)
    inputs = [simulation_input(run, model) for run in runs]
    whole = model
    for effect in candidates:
        whole = whole.add(effect.reference)
    free = tuple(whole.index(v.key) for v in model.values if not v.fixed)
    starts = np.array([i.start_k if np.isfinite(i.start_k) else model["ambient.t_env"] for i in inputs])
    observed = observed_series(inputs, _sigma(runs, CAMERA), _sigma(runs, DISTANCE))
    return Problem(whole, inputs, free, starts, observed, *start_conditions(inputs, model))


def _sigma(runs: Sequence[Run], column: int) -> float | None:
    series = [r.temperature if column == CAMERA else r.displacement for r in runs]
    floors = [noise_floor(s) for s in series if s is not None]
    return float(np.sqrt(np.mean(np.square(floors)))) if floors else None


def _misfit(problem: Problem) -> dict[int, Noise]:
    """What the model leaves of each sensor, as if it were white noise: it balances the two before more is known."""
    first = problem.first()
    sigma = {c: problem.series_rms(first, c) for c in {b.column for b in problem.observed}}
    return {column: Noise(np.empty(0), s, s) for column, s in sigma.items()}
