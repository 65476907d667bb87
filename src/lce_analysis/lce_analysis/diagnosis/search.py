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

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, in_noise, refit
from lce_analysis.diagnosis.score import Score, ScoreTestResult, score_test
from lce_analysis.diagnosis.whitening import Noise
from lce_analysis.identification.discontinuities import without_discontinuities
from lce_analysis.identification.identify import check_runs
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem, observed_series, start_conditions
from lce_analysis.options import DiagnoseOptions
from lce_analysis.prediction import simulation_input
from lce_data.channels import SENSORS, Channel
from lce_data.errors import LceError
from lce_data.noise import sensor_noise
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect

Floats = NDArray[np.float64]

# Numbers of the line search that a refit begins with: they change how long it takes, not where it ends.
LONGEST_FIRST_STEP: Final = 0.3
"""Longest first step of a search variable, a tenth of its bounds."""
STEP_LENGTHS: Final = (1.0, 0.4, 0.15)
"""Shares of that step that are tried."""


@dataclass(frozen=True)
class Refit:
    """The model refitted with one more effect.

    gain : reduction of the squared whitened error; held_out : the same with each run predicted from the others.
    """

    score: Score
    fit: LinearizedFit
    gain: float
    held_out: float

    @property
    def effect(self) -> Effect:
        """Which effect."""
        return self.score.effect


@dataclass(frozen=True)
class Step:
    """One effect accepted: with which it may be confused, and the reduction of the error predicted and found."""

    added: str
    alias_set: tuple[str, ...]
    predicted_reduction: float
    actual_reduction: float


def free_parameters(effect: Effect) -> int:
    """How many parameters the effect adds to a fit."""
    return sum(not p.fixed for p in effect.parameters)


def penalty(effect: Effect, library: int, false_alarm: float) -> float:
    """Reduction of the squared whitened error (-2 ln L) that the effect must exceed: 2 n ln(n_library/p)."""
    return 2.0 * free_parameters(effect) * math.log(library / false_alarm)


def with_effect(problem: Problem, effect: Effect) -> Problem:
    """The problem with the parameters of the effect among the free ones."""
    extra = [i for i, v in enumerate(problem.model.values) if v.term == effect.name and not v.parameter.fixed]
    return replace(problem, free=tuple(sorted({*problem.free, *extra})))


def without_effect(problem: Problem, effect: Effect) -> Problem:
    """The problem with the effect at its null value and its parameters fixed at their defaults."""
    own = {i for i, v in enumerate(problem.model.values) if v.term == effect.name}
    model = problem.model.set({f"{effect.name}.{p.name}": p.default for p in effect.parameters})
    return replace(problem, model=model, free=tuple(i for i in problem.free if i not in own))


def first_step(tested: ScoreTestResult, score: Score) -> Problem:
    """The full model moved to the optimum of the linearisation, as far as that helps; one simulation a length."""
    base, plain = tested.fit.problem, tested.plain
    base = replace(base, observed=in_noise(base.observed, tested.noise))
    z, effect = base.first(), score.effect
    spec = effect.parameter(effect.strength)
    strength = float(np.clip(plain.strength[score.index], spec.lower - effect.null, spec.upper - effect.null))
    shift = np.clip(
        plain.solve[:, -1] - strength * plain.solve[:, score.index], -LONGEST_FIRST_STEP, LONGEST_FIRST_STEP
    )
    best, least = base, math.inf
    for length in STEP_LENGTHS:
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

    def __init__(
        self,
        model: Model,
        runs: Sequence[Run],
        candidates: Sequence[Effect],
        options: DiagnoseOptions,
        progress: Progress,
    ) -> None:
        self.options, self.progress, self.candidates = options, progress, list(candidates)
        self.steps: list[Step] = []
        self.doubtful: list[str] = []
        problem = _problem(model, runs, self.candidates)
        problem = without_discontinuities(self._refit_present(problem, _misfit(problem)).problem)
        self.fit = self._refit_present(problem, _misfit(problem))
        self.score_tests = self._score_tests(_misfit(self.fit.problem))
        self.first_score_tests, self.before = self.score_tests, self.model()

    @property
    def problem(self) -> Problem:
        """The present model beside the data, at its least squares."""
        return self.fit.problem

    def forward(self) -> None:
        """Add effects until nothing passes."""
        while len(self.steps) < self.options.max_effects and self._add_best():
            self.score_tests = self._score_tests(self.score_tests.noise)

    def force(self, effect: Effect) -> bool:
        """Add this effect whatever the data say of it; True if they confirm it."""
        score = next(s for s in self.score_tests.by_reduction if s.effect.name == effect.name)
        (found,) = self._refits([score])
        self._accept(found, [found])
        return self._passes(found)

    def backward(self) -> None:
        """Take out what later additions have made superfluous."""
        noise = self.score_tests.noise
        for step in self.steps[:-1]:
            effect = next(e for e in self.candidates if e.name == step.added)
            label = f"without {effect.name}"
            without = refit(without_effect(self.problem, effect), noise, label, self.progress, self.options.iterations)
            if without.error(noise) - self.fit.error(noise) < self._penalty(effect):
                self.steps.remove(step)
                self.fit = without

    def model(self) -> Model:
        """The present model without the effects that were not accepted."""
        return self._stripped(self.problem.model)

    def remaining(self) -> list[Effect]:
        """Effects that have not been accepted."""
        added = {s.added for s in self.steps}
        return [e for e in self.candidates if e.name not in added]

    def _score_tests(self, noise: Mapping[Channel, Noise]) -> ScoreTestResult:
        """The score test of every effect: test with the noise of the richest fit, refit in units of it, test again."""
        label = "every effect at once"
        self.progress(label, 0, 2, float("nan"))
        noise = score_test(self.fit, self.remaining(), noise, estimate=True).noise
        self.fit = self._refit_present(self.problem, noise)
        self.progress(label, 1, 2, float("nan"))
        critical_value = 2.0 * math.log(len(self.candidates) / self.options.false_alarm)
        return score_test(self.fit, self.remaining(), noise, estimate=True, critical_value=critical_value)

    def _stripped(self, model: Model) -> Model:
        for effect in self.remaining():
            model = model.without(effect.reference)
        return model

    def _refit_present(self, problem: Problem, noise: Mapping[Channel, Noise]) -> LinearizedFit:
        """Least squares without any further effect, in the smaller model, which is several times faster."""
        small = self._stripped(problem.model)
        free = tuple(small.index(problem.model.values[i].key) for i in problem.free)
        alone = replace(problem, model=small, free=free)
        found = refit(alone, noise, "the model as it is", self.progress, self.options.iterations)
        whole = problem.model.set({v.key: v.value for v in found.problem.model.values})
        return replace(found, problem=replace(found.problem, model=whole, free=problem.free))

    def _penalty(self, effect: Effect) -> float:
        return penalty(effect, len(self.candidates), self.options.false_alarm)

    def _add_best(self) -> bool:
        most = self.options.refitted
        likely = [*self.score_tests.scores[:most], *self.score_tests.by_reduction[:most]]
        chosen = {s.effect.name: s for s in reversed(likely) if s.evidence > 0.0 or s.predicted_reduction > 0.0}
        refits = self._refits(list(chosen.values()))
        for best in refits:
            if self._passes(best) and best.score.visibility >= self.options.min_visibility:
                self._accept(best, refits)
                return True
            if best.gain > self._penalty(best.effect):
                self.doubtful.append(best.effect.name)
        return False

    def _refits(self, scores: Sequence[Score]) -> list[Refit]:
        """Least squares of everything with each candidate, judged by one noise, the likeliest first."""
        fits = self._refitted(scores)
        if not fits:
            return []
        noise = self._least_noise(fits)
        error, held_out = self.fit.error(noise), float(self.fit.held_out(noise).sum())
        refits = [
            Refit(score, fit, error - fit.error(noise), held_out - float(fit.held_out(noise).sum()))
            for score, fit in zip(scores, fits, strict=True)
        ]
        return sorted(refits, key=lambda r: self._penalty(r.effect) - r.gain)

    def _refitted(self, scores: Sequence[Score]) -> list[LinearizedFit]:
        """The model refitted with each candidate alone."""
        starts = [(f"with {s.effect.name}", with_effect(first_step(self.score_tests, s), s.effect)) for s in scores]
        tasks = [
            partial(refit, start, self.score_tests.noise, label, iterations=self.options.iterations)
            for label, start in starts
        ]
        return list(each(tasks, "refits", self.progress))

    def _least_noise(self, fits: Sequence[LinearizedFit]) -> dict[Channel, Noise]:
        """Of each channel the noise that the best refit leaves, or that of the richest linear fit if it is less."""
        noise = self.score_tests.noise
        left = min(fits, key=lambda fit: fit.plain_error(noise)).noise(noise)
        return {channel: min(left[channel], noise[channel], key=lambda n: n.rms) for channel in noise}

    def _passes(self, found: Refit) -> bool:
        return found.gain > self._penalty(found.effect) and found.held_out > 0.0

    def _accept(self, best: Refit, refits: Sequence[Refit]) -> None:
        noise = self.score_tests.noise
        reduction = 1.0 - best.fit.plain_error(noise) / self.fit.plain_error(noise)
        alias_set = self._alias_set(best, refits)
        self.steps.append(Step(best.effect.name, alias_set, best.score.predicted_reduction, reduction))
        self.fit = best.fit

    def _alias_set(self, best: Refit, refits: Sequence[Refit]) -> tuple[str, ...]:
        """The effects that explain the same: refitted nearly as well, or collinear and never refitted.

        Collinear is not enough if the bounds of the other's strength leave it too little of the evidence.
        """

        def penalised(r: Refit) -> float:
            return self._penalty(r.effect) - r.gain

        threshold = 2.0 * math.log(self.options.min_likelihood_ratio)
        close = [r.effect.name for r in refits if penalised(r) - penalised(best) < threshold]
        refitted = {r.effect.name for r in refits}
        collinear = [
            s.effect.name
            for s in self.score_tests.scores
            if s.effect.name not in refitted
            and s.evidence > self.options.alias_evidence * best.score.evidence
            and self.score_tests.collinearity(best.score, s.effect.name) >= self.options.alias_correlation
        ]
        return tuple(dict.fromkeys([best.effect.name, *close, *collinear]))


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
    observed = observed_series(inputs, sensor_noise(runs, SENSORS))
    return Problem(whole, inputs, free, starts, observed, *start_conditions(inputs, model))


def _misfit(problem: Problem) -> dict[Channel, Noise]:
    """The RMS residual of each sensor, taken for white noise: it balances the sensors before their noise is known."""
    first = problem.first()
    channels = dict.fromkeys(series.channel for series in problem.observed)
    sigma = {channel: problem.series_rms(first, channel) for channel in channels}
    return {channel: Noise(np.empty(0), s, s) for channel, s in sigma.items()}
