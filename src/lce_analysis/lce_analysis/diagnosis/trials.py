# SPDX-License-Identifier: Apache-2.0
"""Trials of the candidates of a stage: the few that promise most, refitted and judged, and a record of all of them."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Final

from lce_analysis.diagnosis.held_out import DataLeftOut
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, gained, optimum, refit, samples
from lce_analysis.diagnosis.misfit import NOISE
from lce_analysis.diagnosis.score import Score, ScoreTestResult, score_test
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.diagnosis.strength import strengths_of
from lce_analysis.diagnosis.trial import Objection, Trial, effect_alone, first_step, objection, penalty, with_effect
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem
from lce_analysis.options import DiagnoseOptions
from lce_data.progress import Progress
from lce_model.effects import Effect

FIRST_STEPS: Final = 15
"""Steps after which it is seen which trials lead."""
DISAPPOINTING: Final = 0.5
"""A refit that gains less than this share of what was predicted may have left the way to a better minimum."""


class Trials:
    """Tries candidates, and keeps the latest that is known of each.

    scores, tried, aliases : by name of the effect, its score test, its trial, and effects that look like it.
    refused : names of the effects that were not accepted although their trial passed, or were taken back.
    set_aside : names of the effects that are not tried for now.
    """

    def __init__(self, candidates: int, left_out: DataLeftOut, options: DiagnoseOptions, progress: Progress) -> None:
        self.candidates, self.left_out, self.options, self.progress = candidates, left_out, options, progress
        self.scores: dict[str, Score] = {}
        self.tried: dict[str, Trial] = {}
        self.aliases: dict[str, tuple[str, ...]] = {}
        self.refused: set[str] = set()
        self.set_aside: set[str] = set()

    def likely(self, stages: Sequence[StageProblem]) -> list[Trial]:
        """The candidates that promise most, refitted, not judged yet; the best first."""
        trials: list[Trial] = []
        for stage in (s for s in stages if s.candidates):
            tested = self._tested(stage)
            trials += self._refitted(stage, tested, self._promising(stage, tested.scores))
        return sorted(trials, key=self._lost)

    def of(self, effect: Effect, stages: Sequence[StageProblem]) -> Trial:
        """One effect, tried and judged where it does most, whatever it promises."""
        trials: list[Trial] = []
        for stage in stages:
            tested = self._tested(stage)
            trials += self._refitted(stage, tested, [s for s in tested.scores if s.effect == effect])
        judged = [self._judged(trial) for trial in trials]
        best = min(judged, key=lambda t: (bool(t.objection), self._lost(t)))
        if best.held_out is None:
            best = replace(best, held_out=self.left_out.errors(best.stage, best.fit.problem, effect.name))
        self.tried[effect.name] = best
        return best

    def judged(self, trials: Sequence[Trial]) -> list[Trial]:
        """The same, the best few judged on data left out; of the others, whether anything else speaks against them."""
        found = []
        for i, trial in enumerate(trials):
            judged = self._judged(trial, on_data_left_out=i < self.options.contenders)
            found.append(judged if judged.objection or judged.held_out else replace(judged, objection="less"))
        self.tried |= {trial.effect.name: trial for trial in found}
        return found

    def judged_at(self, trial: Trial, fit: LinearizedFit) -> Trial:
        """A trial judged by another fit with its effect; as it was if something speaks against it there, too."""
        found = self._judged(replace(trial, fit=fit, gain=gained(trial.stage.fit, fit)))
        if found.objection:
            return trial
        self.tried[trial.effect.name] = found
        return found

    def objection(self, trial: Trial) -> Objection:
        """What speaks against the effect."""
        return objection(trial, self.candidates, self.options)

    def reject(self, trial: Trial, reason: Objection) -> None:
        """Note why an effect was not accepted."""
        self.tried[trial.effect.name] = replace(trial, objection=reason)
        self.refused.add(trial.effect.name)

    def forget_behind_heat(self) -> None:
        """Forget the trials of the deformation: beside another minimum they say nothing."""
        self.tried = {name: trial for name, trial in self.tried.items() if trial.stage.part == "heat"}

    def alias_set(self, best: Trial, trials: Sequence[Trial]) -> tuple[str, ...]:
        """The effects that explain the same: refitted nearly as well, or collinear and never refitted.

        What the base model lacks beside them decides between two that are collinear and differ by less than that.
        """
        inflation = best.strengths.inflation if best.strengths else 1.0
        threshold = 2.0 * math.log(self.options.min_likelihood_ratio) * inflation
        beyond_noise = best.fit.error - NOISE * sum(samples(best.fit.problem.observed).values())
        collinear = self.aliases[best.effect.name]
        rivals = [t for t in trials if t.stage.part == best.stage.part and t.objection != "null"]
        close = [
            t.effect.name
            for t in rivals
            if best.gain - t.gain < (max(threshold, beyond_noise) if t.effect.name in collinear else threshold)
        ]
        refitted = {t.effect.name for t in trials}
        never_refitted = [
            name
            for name in collinear
            if name not in refitted
            and self.scores[name].predicted_gain > self.options.alias_evidence * best.score.predicted_gain
        ]
        return tuple(dict.fromkeys([best.effect.name, *close, *never_refitted]))

    def _tested(self, stage: StageProblem) -> ScoreTestResult:
        """The score test of a stage; what it says of each effect is kept."""
        critical_value = 2.0 * math.log(max(self.candidates, 1) / self.options.false_alarm)
        tested = score_test(stage.fit, stage.candidates, critical_value)
        for score in tested.scores:
            others = [o.effect.name for o in tested.scores if o is not score]
            alike = [o for o in others if tested.collinearity(score, o) >= self.options.alias_correlation]
            self.scores[score.effect.name] = score
            self.aliases[score.effect.name] = tuple(alike)
        return tested

    def _promising(self, stage: StageProblem, scores: Sequence[Score]) -> Sequence[Score]:
        """The few that promise most, of those that promise a fair part of what would be worth having."""
        gain = self.options.promise * self.options.worth_noise * min(samples(stage.fit.problem.observed).values())
        share = self.options.promise * self.options.worth_share
        tried = (s for s in scores if s.effect.name not in self.set_aside)
        fair = [s for s in tried if s.predicted_gain > gain and s.predicted_reduction > share]
        return fair[: self.options.refitted]

    def _refitted(self, stage: StageProblem, tested: ScoreTestResult, scores: Sequence[Score]) -> list[Trial]:
        """Effects refitted for a few steps, each from its best start; those that lead, to the end."""
        starts = [first_step(stage, s, tested.plain.solve) for s in scores]
        trials = self._from(stage, scores, starts, FIRST_STEPS)
        poor = [t.score for t in trials if t.gain < DISAPPOINTING * t.score.predicted_gain]
        again = self._from(stage, poor, [effect_alone(stage, s) for s in poor], FIRST_STEPS)
        most = max((t.gain for t in [*trials, *again]), default=0.0)
        promising = [s for s in poor if s.predicted_gain > most]
        held = self._from(stage, promising, [self._held(stage, s) for s in promising], FIRST_STEPS)
        best = {t.effect.name: t for t in sorted([*trials, *again, *held], key=lambda trial: trial.gain)}
        leading = sorted(best.values(), key=self._lost)[: self.options.contenders]
        to_the_end = self._from(
            stage, [t.score for t in leading], [t.fit.problem for t in leading], self.options.iterations
        )
        return list((best | {t.effect.name: t for t in to_the_end}).values())

    def _held(self, stage: StageProblem, score: Score) -> Problem:
        """The base refitted beside the effect at the strength that is expected of it.

        An effect that promises more than any other has gained may do nothing but harm before all else has moved.
        """
        base = stage.fit.problem
        there = replace(base, model=base.model.set(score.direction.at(score.expected_strength)))
        return optimum(there, f"beside {score.effect.name}", self.progress, FIRST_STEPS)

    def _from(
        self, stage: StageProblem, scores: Sequence[Score], starts: Sequence[Problem], iterations: int
    ) -> list[Trial]:
        """Effects refitted, each from its start."""
        tasks = [
            partial(refit, with_effect(start, s.effect), f"with {s.effect.name}", iterations=iterations)
            for start, s in zip(starts, scores, strict=True)
        ]
        fits = each(tasks, "refits", self.progress)
        return [Trial(stage, s, fit, stage.fit.error - fit.error) for s, fit in zip(scores, fits, strict=True)]

    def _judged(self, trial: Trial, on_data_left_out: bool = True) -> Trial:
        problem = trial.fit.problem
        trial = replace(trial, strengths=strengths_of(trial.fit, trial.effect))
        found = self.objection(trial)
        if found or not on_data_left_out:
            return replace(trial, objection=found)
        trial = replace(trial, held_out=self.left_out.errors(trial.stage, problem, trial.effect.name))
        return replace(trial, objection=self.objection(trial))

    def _lost(self, trial: Trial) -> float:
        """Penalty less gain: the best trial has least."""
        return penalty(trial.effect, self.candidates, self.options.false_alarm) - trial.gain
