# SPDX-License-Identifier: Apache-2.0
"""Forward and backward through the library, stage by stage: try the likeliest, keep what is worth having.

The heat is searched first, on the temperature alone; then the deformation. The search of a stage ends when nothing
more passes; then every accepted effect has to prove itself once more against the others.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

from lce_analysis.diagnosis.held_out import DataLeftOut, HeldOut
from lce_analysis.diagnosis.linearized_fit import refit, samples
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, reduction, share_removed
from lce_analysis.diagnosis.score import Score, ScoreTestResult, score_test
from lce_analysis.diagnosis.stage_problem import Data, StagedFit, StageProblem, refit_stages, with_candidates
from lce_analysis.diagnosis.strength import strengths
from lce_analysis.diagnosis.trial import Trial, first_step, gets_worse, objection, penalty, with_effect
from lce_analysis.identification.identify import check_runs
from lce_analysis.identification.identify import fit as identify
from lce_analysis.identification.parallel import each
from lce_analysis.options import DiagnoseOptions, Drive
from lce_analysis.prediction import simulation_input
from lce_data.channels import SENSORS
from lce_data.errors import LceError
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect

RESTARTS: Final = 2
"""Times that a base caught in a poor minimum is refitted from elsewhere."""
SURPRISE: Final = 1.5
"""A trial that gains so many times what was predicted may have left a poor minimum of the base."""
BETTER: Final = 0.02
"""Share of the squared error by which another minimum must be better."""


@dataclass(frozen=True)
class Step:
    """One effect accepted.

    trial : what was found in its stage.
    alias_set : its name, and those of effects that explain the same.
    without, with_it : the model refitted without and with it, all stages.
    train : errors of these two on the runs; held_out : on what was left out.
    """

    trial: Trial
    alias_set: tuple[str, ...]
    without: StagedFit
    with_it: StagedFit
    train: tuple[Misfit, Misfit]
    held_out: HeldOut

    @property
    def added(self) -> str:
        """Name of the effect."""
        return self.trial.effect.name

    @property
    def predicted_reduction(self) -> float:
        """Share of the error above the noise, in the sensors of its stage, that the score test promised."""
        return self.trial.score.predicted_reduction

    @property
    def actual_reduction(self) -> float:
        """The share that went, of the two models simulated."""
        return reduction(*self.train, self.trial.stage.channels)


class Search:
    """The present model beside the runs, and what has been accepted and tried so far.

    base, present : the model refitted without any addition, and with what has been accepted.
    steps : what has been accepted, in its order.
    scores, tried, aliases : by effect, the latest score test, trial, and effects that look like it.
    """

    def __init__(
        self,
        model: Model,
        runs: Sequence[Run],
        test_runs: Sequence[Run],
        candidates: Sequence[Effect],
        options: DiagnoseOptions,
        progress: Progress,
    ) -> None:
        if not runs:
            raise LceError("no runs to diagnose")
        check_runs(model, runs)
        self.options, self.progress, self.candidates = options, progress, tuple(candidates)
        self.data = Data(JudgedRuns.of(runs), tuple(simulation_input(run, model) for run in runs))
        self.coarse = self.data.coarse
        self.tests = JudgedRuns.of(test_runs)
        self.left_out = DataLeftOut(self.data.judged, self.tests, progress)
        self.steps: list[Step] = []
        self.scores: dict[str, Score] = {}
        self.tried: dict[str, Trial] = {}
        self.aliases: dict[str, tuple[str, ...]] = {}
        self.present = self._stagewise(model)
        self.base = self._no_worse(model, self._on_every_sample(self.present))

    def run(self) -> None:
        """Search the heat, then the deformation, then look back."""
        self._forward(heat=True)
        self._forward(heat=False)
        self._backward()
        self._finish()

    def _finish(self) -> None:
        """Refit what was accepted on every sample, and tell every step between the models that this gives."""
        fits = [self.base, *(self._on_every_sample(step.with_it) for step in self.steps)]
        self.present = fits[-1]
        self.steps = [
            self._step_between(step.trial, step.alias_set, without, with_it, self.present.drive)
            for step, without, with_it in zip(self.steps, fits[:-1], fits[1:], strict=True)
        ]

    def force(self, effect: Effect) -> Trial:
        """Accept this effect, whatever the data say of it; the trial says what they do."""
        stages = [s for s in (*self._stages(True), *self._stages(False)) if effect in s.candidates]
        if not stages:
            raise LceError(f"{effect.name}: it changes nothing that these runs measured")
        trials = [self._judged(t, contender=True) for s in stages for t in self._refitted_likely(s, [effect])]
        best = min(trials, key=lambda t: (bool(t.objection), self._penalty(t.effect) - t.gain))
        if best.held_out is None:
            best = replace(best, held_out=self.left_out.errors(best.stage, best.fit.problem, effect.name))
        self._accept(self._step(best, (effect.name,)))
        self._finish()
        return best

    def _stagewise(self, model: Model) -> StagedFit:
        """The model refitted stage by stage, beside it the candidates that it lacks."""
        left = [e for e in self.candidates if e.reference not in model.effects]
        return refit_stages(model, self.coarse, left, self.options, self.progress)

    def _on_every_sample(self, fit: StagedFit) -> StagedFit:
        left = [e for e in self.candidates if e.reference not in fit.model.effects]
        return refit_stages(fit.model, self.data, left, self.options, self.progress)

    def _no_worse(self, given: Model, refitted: StagedFit) -> StagedFit:
        """The refit, or the model as given where no sensor has gained by it: the jumps may lie better there."""
        before, after = (self.misfit(model, refitted.drive) for model in (given, refitted.model))
        gained = any(after.mean_square(c) < before.mean_square(c) for c in before.total)
        return refitted if gained else replace(refitted, model=given)

    def _forward(self, heat: bool) -> None:
        """Search one part of the model; what was found stays if it explains most of what was to be explained."""
        began = len(self.steps)
        while len(self.steps) < self.options.max_effects:
            trials = self._tried(heat)
            step = next((s for t in trials if not t.objection and (s := self._confirmed(t, trials))), None)
            if step is None:
                break
            self._accept(step)
        while len(self.steps) > began and not self._explains(self.steps[-1]):
            step = self.steps.pop()
            self.present = step.without
            self.tried[step.added] = replace(step.trial, objection="part")

    def _explains(self, last: Step) -> bool:
        """Does the last effect of a part of the model take most of what was left of the error of a sensor?

        If not, it stands in for something else, that the library or the base model lacks.
        """
        before, after = last.held_out.errors.judged_before, last.held_out.errors.judged_after
        for channel in (c for c in last.trial.stage.channels if c in before.total):
            fall = before.mean_square(channel) - after.mean_square(channel)
            close = after.mean_square(channel) <= self.options.near**2
            needed = self.options.most if close else self.options.nearly_all
            if fall > self.options.worth_noise and share_removed(before, after, channel) >= needed:
                return True
        return False

    def _tried(self, heat: bool) -> list[Trial]:
        """Trials of one part of the model, the best first; the base moves first where they show a better minimum."""
        for _ in range(RESTARTS + 1):
            stages = self._stages(heat)
            trials = [trial for stage in stages for trial in self._refitted_likely(stage, stage.candidates)]
            trials.sort(key=lambda t: self._penalty(t.effect) - t.gain)
            better = self._better_minimum(trials)
            if better is None:
                break
            self.present = better
        judged = [self._judged(t, contender=i < self.options.contenders) for i, t in enumerate(trials)]
        self.tried |= {t.effect.name: t for t in judged}
        return judged

    def _better_minimum(self, trials: Sequence[Trial]) -> StagedFit | None:
        """The present model refitted from where its best trial ended, if that is better: it was in a poor minimum.

        A sign of it is a trial that gains far more than was predicted.
        """
        surprising = [t for t in trials if t.gain > SURPRISE * t.score.predicted_gain]
        if not surprising:
            return None
        best = surprising[0]
        values = [v for v in best.fit.problem.model.values if v.term != best.effect.name]
        start = self.present.model.set({v.key: v.value for v in values if v.key in self.present.model})
        found = self._stagewise(start)
        return found if self._total(found) < self._total(self.present) * (1.0 - BETTER) else None

    @staticmethod
    def _total(fit: StagedFit) -> float:
        """Squared error of all sensors, each by its mean."""
        squares = {c: x for p in (*fit.heat[:1], fit.deformation) if p for c, x in p.fit.mean_squares.items()}
        return sum(squares.values())

    def _backward(self) -> None:
        """Take out what later additions have made superfluous."""
        for step in self.steps[:-1]:
            reference = step.trial.effect.reference
            without = self._stagewise(self.present.model.without(reference))
            before, after = (self.misfit(fit.model, self.present.drive) for fit in (without, self.present))
            worth = self.options.worth_noise
            if all(before.mean_square(c) - after.mean_square(c) < worth for c in before.total):
                later = self.steps[self.steps.index(step) + 1 :]
                fits = [self._stagewise(s.with_it.model.without(reference)) for s in later[:-1]] + [without]
                self.steps = [
                    *self.steps[: self.steps.index(step)],
                    *(replace(s, with_it=fit) for s, fit in zip(later, fits, strict=True)),
                ]
                self.tried[step.added] = replace(step.trial, objection="less")
                self.present = without

    def _stages(self, heat: bool) -> tuple[StageProblem, ...]:
        if heat:
            return self.present.heat
        return () if self.present.deformation is None else (self.present.deformation,)

    def _refitted_likely(self, stage: StageProblem, effects: Sequence[Effect]) -> list[Trial]:
        """The likeliest effects refitted."""
        tested = score_test(stage.fit, stage.candidates, self._critical_value)
        self._note(tested)
        likely = [s for s in tested.scores if s.effect in effects]
        if len(effects) > 1:
            likely = self._likely(stage, likely)
        return self._refitted(stage, tested, likely)

    def _likely(self, stage: StageProblem, scores: list[Score]) -> list[Score]:
        """The few that promise most, of those that promise a fair part of what would be worth having."""
        least = self.options.promise * self.options.worth_noise * min(samples(stage.fit.problem.observed).values())
        return [s for s in scores if s.predicted_gain > least][: self.options.refitted]

    def _note(self, tested: ScoreTestResult) -> None:
        """Keep what the score test says of each effect."""
        for score in tested.scores:
            name = score.effect.name
            self.scores[name] = score
            others = [o.effect.name for o in tested.scores if o is not score]
            alike = [o for o in others if tested.collinearity(score, o) >= self.options.alias_correlation]
            self.aliases[name] = tuple(alike)

    def _refitted(self, stage: StageProblem, tested: ScoreTestResult, scores: Sequence[Score]) -> list[Trial]:
        starts = [with_effect(first_step(stage, s, tested.plain.solve), s.effect) for s in scores]
        tasks = [
            partial(refit, start, f"with {s.effect.name}", iterations=self.options.iterations)
            for start, s in zip(starts, scores, strict=True)
        ]
        fits = each(tasks, "refits", self.progress)
        return [Trial(stage, s, fit, stage.fit.error - fit.error) for s, fit in zip(scores, fits, strict=True)]

    def _judged(self, trial: Trial, contender: bool) -> Trial:
        problem = trial.fit.problem
        column = problem.free.index(problem.model.index(trial.effect.strength_key))
        trial = replace(trial, strengths=strengths(trial.fit, column))
        trial = replace(trial, objection=objection(trial, len(self.candidates), self.options))
        if trial.objection or not contender:
            return trial if trial.objection else replace(trial, objection="less")
        held_out = self.left_out.errors(trial.stage, trial.fit.problem, trial.effect.name)
        trial = replace(trial, held_out=held_out)
        return replace(trial, objection=objection(trial, len(self.candidates), self.options))

    def _confirmed(self, trial: Trial, trials: Sequence[Trial]) -> Step | None:
        """The step that accepts the effect; None if another sensor pays for it on the runs held out."""
        step = self._step(trial, self._alias_set(trial, trials))
        if gets_worse(trial.stage, step.held_out, self.options):
            self.tried[trial.effect.name] = replace(trial, objection="worse")
            return None
        return step

    def _step(self, trial: Trial, alias_set: tuple[str, ...]) -> Step:
        found = trial.fit.problem.model
        model = self.present.model.add(trial.effect.reference)
        after = self._stagewise(model.set({v.key: found[v.key] for v in model.values if v.key in found}))
        if trial.stage.part != "heat" and self._worst(after) > self.options.near:
            after, trial = self._searched_anew(after, trial)
        return self._step_between(trial, alias_set, self.present, after, after.drive)

    def _searched_anew(self, fit: StagedFit, trial: Trial) -> tuple[StagedFit, Trial]:
        """Where much is left, the deformation identified from scratch, with the effect; if that explains more."""
        runs = [run_input.run for run_input in self.coarse.inputs]
        anew = self._stagewise(identify(fit.model, runs, progress=self.progress).model)
        if anew.deformation is None or self._total(anew) > self._total(fit) * (1.0 - BETTER):
            return fit, trial
        problem = anew.deformation.fit.problem
        return anew, replace(trial, held_out=self.left_out.errors(trial.stage, problem, trial.effect.name))

    @staticmethod
    def _worst(fit: StagedFit) -> float:
        """The largest RMS error of a sensor, in units of its noise."""
        problems = [p for p in (*fit.heat[:1], fit.deformation) if p is not None]
        return max((math.sqrt(x) for p in problems for x in p.fit.mean_squares.values()), default=0.0)

    def _step_between(
        self, trial: Trial, alias_set: tuple[str, ...], without: StagedFit, with_it: StagedFit, drive: Drive
    ) -> Step:
        """A step with its errors, the deformation driven in the same way without and with the effect."""
        train = self.misfit(without.model, drive), self.misfit(with_it.model, drive)
        held_out = trial.held_out
        assert held_out is not None
        if self.tests.runs:
            models = self.whole(without.model), self.whole(with_it.model)
            held_out = replace(held_out, errors=self.tests.pair(*models, drive, SENSORS))
        return Step(trial, alias_set, without, with_it, train, held_out)

    def _accept(self, step: Step) -> None:
        self.steps.append(step)
        self.present = step.with_it

    def misfit(self, model: Model, drive: Drive, judged: JudgedRuns | None = None) -> Misfit:
        """Errors of a model simulated beside the runs, or others."""
        return (self.data.judged if judged is None else judged).misfit(self.whole(model), drive)

    def whole(self, model: Model) -> Model:
        """The model with all candidates at their null values, where they change nothing: it is compiled already."""
        return with_candidates(model, self.candidates)

    def _alias_set(self, best: Trial, trials: Sequence[Trial]) -> tuple[str, ...]:
        """The effects that explain the same: refitted nearly as well, or collinear and never refitted."""
        inflation = best.strengths.inflation if best.strengths else 1.0
        threshold = 2.0 * math.log(self.options.min_likelihood_ratio) * inflation
        close = [t.effect.name for t in trials if t.stage.part == best.stage.part and best.gain - t.gain < threshold]
        refitted = {t.effect.name for t in trials}
        collinear = [
            name
            for name in self.aliases[best.effect.name]
            if name not in refitted
            and self.scores[name].predicted_gain > self.options.alias_evidence * best.score.predicted_gain
        ]
        return tuple(dict.fromkeys([best.effect.name, *close, *collinear]))

    @property
    def _critical_value(self) -> float:
        """Evidence beyond which a strength would not be chance."""
        return 2.0 * math.log(max(len(self.candidates), 1) / self.options.false_alarm)

    def _penalty(self, effect: Effect) -> float:
        return penalty(effect, len(self.candidates), self.options.false_alarm)
