# SPDX-License-Identifier: Apache-2.0
"""Forward and backward through the library, stage by stage: try the likeliest, keep what is worth having.

The heat is searched first, on the temperature alone; then the deformation. The search of a stage ends when nothing
more passes; then every accepted effect has to prove itself once more against the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from lce_analysis.diagnosis.held_out import DataLeftOut, HeldOut
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, reduction, share_removed
from lce_analysis.diagnosis.stage_problem import Data, StagedFit, StageProblem, refit_stages, with_candidates
from lce_analysis.diagnosis.trial import Objection, Trial, gets_worse, rises
from lce_analysis.diagnosis.trials import Trials
from lce_analysis.identification.identify import check_runs
from lce_analysis.identification.identify import fit as identify
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
    """The present model beside the runs, and what has been accepted so far.

    base, present : the model refitted without any addition, and with what has been accepted.
    steps : what has been accepted, in its order.
    trials : what is known of every candidate.
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
        self.trials = Trials(len(self.candidates), self.left_out, options, progress)
        self.steps: list[Step] = []
        self.present = self._refitted(model)
        self.base = self._no_worse(model, self._refitted(self.present.model, every_sample=True))

    def run(self) -> None:
        """Search the heat, then the deformation, then look back."""
        self._forward(heat=True)
        self._forward(heat=False)
        self._backward()
        self._finish()
        while self.steps and not _helped(self.steps[-1], self.options):
            self._drop_last("worse")
            self._finish()

    def force(self, effect: Effect) -> Step:
        """Accept this effect, whatever the data say of it; the objection of the step's trial is what they do."""
        stages = [s for s in (*self._stages(heat=True), *self._stages(heat=False)) if effect in s.candidates]
        if not stages:
            raise LceError(f"{effect.name}: it changes nothing that these runs measured")
        trial = self.trials.of(effect, stages)
        step = self._step(trial, (effect.name,))
        trial = replace(step.trial, objection=self.trials.objection(step.trial))
        self._accept(replace(step, trial=trial))
        self._finish()
        (step,) = self.steps
        if not trial.objection and not _helped(step, self.options):
            step = replace(step, trial=replace(trial, objection="worse"))
        return step

    def misfit(self, model: Model, drive: Drive, judged: JudgedRuns | None = None) -> Misfit:
        """Errors of a model simulated beside the runs, or others."""
        return (self.data.judged if judged is None else judged).misfit(self.whole(model), drive)

    def whole(self, model: Model) -> Model:
        """The model with all candidates at their null values, where they change nothing: it is compiled already."""
        return with_candidates(model, self.candidates)

    def _forward(self, heat: bool) -> None:
        """Search one part of the model; what was found stays if it explains most of what was to be explained."""
        began = len(self.steps)
        while len(self.steps) < self.options.max_effects:
            trials = self.trials.judged(self._tried(heat))
            step = next((s for t in trials if not t.objection and (s := self._confirmed(t, trials))), None)
            if step is None:
                break
            self._accept(step)
        while len(self.steps) > began and not _explains(self.steps[-1], self.options):
            self._drop_last("part")

    def _tried(self, heat: bool) -> list[Trial]:
        """Trials of one part of the model; the base moves first where they show a better minimum."""
        trials = self.trials.likely(self._stages(heat))
        for _ in range(RESTARTS):
            better = self._better_minimum(trials)
            if better is None:
                break
            self.present = better
            trials = self.trials.likely(self._stages(heat))
        return trials

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
        found = self._refitted(start)
        return found if found.error < self.present.error * (1.0 - BETTER) else None

    def _backward(self) -> None:
        """Take out what later additions have made superfluous."""
        for step in self.steps[:-1]:
            reference = step.trial.effect.reference
            without = self._refitted(self.present.model.without(reference))
            before, after = (self.misfit(fit.model, self.present.drive) for fit in (without, self.present))
            if any(before.mean_square(c) - after.mean_square(c) >= self.options.worth_noise for c in before.total):
                continue
            place = self.steps.index(step)
            earlier, later = self.steps[:place], self.steps[place + 1 :]
            fits = [*(self._refitted(s.with_it.model.without(reference)) for s in later[:-1]), without]
            self.steps = [*earlier, *(replace(s, with_it=fit) for s, fit in zip(later, fits, strict=True))]
            self.trials.reject(step.trial, "less")
            self.present = without

    def _finish(self) -> None:
        """Refit what was accepted on every sample, and tell every step between the models that this gives."""
        fits = [self.base, *(self._refitted(step.with_it.model, every_sample=True) for step in self.steps)]
        self.present = fits[-1]
        self.steps = [
            self._step_between(step.trial, step.alias_set, without, with_it, self.present.drive)
            for step, without, with_it in zip(self.steps, fits[:-1], fits[1:], strict=True)
        ]

    def _refitted(self, model: Model, every_sample: bool = False) -> StagedFit:
        """The model refitted stage by stage, beside it the candidates that it lacks; a search takes a coarser grid."""
        left = [e for e in self.candidates if e.reference not in model.effects]
        return refit_stages(model, self.data if every_sample else self.coarse, left, self.options, self.progress)

    def _no_worse(self, given: Model, refitted: StagedFit) -> StagedFit:
        """The refit, or the model as given where no sensor has gained by it: the jumps may lie better there."""
        before, after = (self.misfit(model, refitted.drive) for model in (given, refitted.model))
        gained = any(after.mean_square(c) < before.mean_square(c) for c in before.total)
        return refitted if gained else replace(refitted, model=given)

    def _stages(self, heat: bool) -> tuple[StageProblem, ...]:
        if heat:
            return self.present.heat
        return () if self.present.deformation is None else (self.present.deformation,)

    def _confirmed(self, trial: Trial, trials: Sequence[Trial]) -> Step | None:
        """The step that accepts the effect; None if another sensor pays for it on the runs held out."""
        step = self._step(trial, self.trials.alias_set(trial, trials))
        if gets_worse(trial.stage, step.held_out, self.options):
            self.trials.reject(trial, "worse")
            return None
        return step

    def _step(self, trial: Trial, alias_set: tuple[str, ...]) -> Step:
        found = trial.fit.problem.model
        model = self.present.model.add(trial.effect.reference)
        after = self._refitted(model.set({v.key: found[v.key] for v in model.values if v.key in found}))
        if trial.stage.part != "heat" and after.worst > self.options.near:
            after, trial = self._searched_anew(after, trial)
        return self._step_between(trial, alias_set, self.present, after, after.drive)

    def _searched_anew(self, fit: StagedFit, trial: Trial) -> tuple[StagedFit, Trial]:
        """Where much is left, the deformation identified from scratch, with the effect; if that explains more."""
        runs = [run_input.run for run_input in self.coarse.inputs]
        anew = self._refitted(identify(fit.model, runs, progress=self.progress).model)
        if anew.deformation is None or anew.error > fit.error * (1.0 - BETTER):
            return fit, trial
        problem = anew.deformation.fit.problem
        return anew, replace(trial, held_out=self.left_out.errors(trial.stage, problem, trial.effect.name))

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

    def _drop_last(self, reason: Objection) -> None:
        step = self.steps.pop()
        self.present = step.without
        self.trials.reject(step.trial, reason)


def _explains(last: Step, options: DiagnoseOptions) -> bool:
    """Does the last effect of a part of the model take most of what was left of the error of a sensor?

    If not, it stands in for something else, that the library or the base model lacks. Where the heat is not explained,
    and the measured temperature drives the deformation, the effect has to bring the displacement near its noise.
    """
    driven = last.trial.stage.drive == "measured"
    before, after = last.held_out.errors.judged_before, last.held_out.errors.judged_after
    for channel in (c for c in last.trial.stage.channels if c in before.total):
        fall = before.mean_square(channel) - after.mean_square(channel)
        close = after.mean_square(channel) <= options.near**2
        needed = options.most if close and not driven else options.nearly_all
        share = share_removed(before, after, channel)
        if fall > options.worth_noise and share >= needed and (close or not driven):
            return True
    return False


def _helped(step: Step, options: DiagnoseOptions) -> bool:
    """Do the final tables bear the step out: less error in the runs and on data left out, of no sensor much more?"""
    if rises(step.trial.stage, *step.train, options.bent, options):
        return False
    before, after = step.held_out.before, step.held_out.after
    channels = [c for c in step.trial.stage.channels if c in before.total]
    falls = any(after.mean_square(c) < before.mean_square(c) for c in channels)
    return step.actual_reduction > 0.0 and falls and not gets_worse(step.trial.stage, step.held_out, options)
