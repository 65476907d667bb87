# SPDX-License-Identifier: Apache-2.0
"""Forward and backward through the library, stage by stage: try the likeliest, keep what is worth having.

The heat is searched first, on the temperature alone; then the deformation. In each step the effects of the library
compete with the parameters of the base model that may differ from run to run. The search of a stage ends when nothing
more passes; then everything that was accepted has to prove itself once more beside the rest.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Final, TypeVar

from lce_analysis.diagnosis.accepted import Accepted, Step, VariationStep
from lce_analysis.diagnosis.held_out import DataLeftOut, HeldOut
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, reduction, reduction_of, share_removed
from lce_analysis.diagnosis.stage_problem import (
    Data,
    StagedFit,
    StageProblem,
    carried,
    refit_stages,
    with_candidates,
)
from lce_analysis.diagnosis.trial import Objection, Trial, gets_worse, goes_far, on_data_left_out, rises
from lce_analysis.diagnosis.trials import Trials
from lce_analysis.diagnosis.variation import VariationTrial, variation_trial
from lce_analysis.identification.identify import check_runs
from lce_analysis.identification.identify import fit as identify
from lce_analysis.identification.random_effects import with_run_errors
from lce_analysis.options import DiagnoseOptions, Drive, FitOptions
from lce_analysis.prediction import simulation_input, with_ambient_at_rest
from lce_data.channels import SENSORS, TEMPERATURE
from lce_data.errors import LceError
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model, Variation
from lce_model.effects import Effect

Kind = TypeVar("Kind", Step, VariationStep)
RESTARTS: Final = 2
"""Times that a base caught in a poor minimum is refitted from elsewhere."""
SURPRISE: Final = 1.5
"""A trial that gains so many times what was predicted may have left a poor minimum of the base."""
SIMPLER: Final = 0.9
"""An effect that takes this share of what a value for each run takes is preferred: it is one number, not as many."""
FINE: Final = 15
"""Iterations of a refit on every sample, at most: it begins at the optimum of the coarser grid, close to its own."""
BETTER: Final = 0.02
"""Share of the squared error by which another minimum must be better."""


class Search:
    """The present model beside the runs, and what has been accepted so far.

    given : the model before any refit.
    base, present : the model refitted without any addition, and with what has been accepted.
    accepted : what has been accepted, in its order: effects, and parameters that differ from run to run.
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
        model = with_ambient_at_rest(model, runs)
        self.given = model
        self.options, self.progress, self.candidates = options, progress, tuple(candidates)
        self.data = Data(JudgedRuns.of(runs), tuple(simulation_input(run, model) for run in runs))
        self.coarse = self.data.coarse
        self.tests = JudgedRuns.of(test_runs)
        self.left_out = DataLeftOut(self.data.judged, self.tests, progress)
        self.trials = Trials(len(self.candidates), self.left_out, options, progress)
        self.accepted: list[Accepted] = []
        self.present = self._refitted(model)
        self.base = self._no_worse(model, self._refitted(self.present.model, every_sample=True))

    @property
    def steps(self) -> list[Step]:
        """The effects accepted."""
        return [a for a in self.accepted if isinstance(a, Step)]

    @property
    def variations(self) -> list[VariationStep]:
        """The parameters found to differ from run to run."""
        return [a for a in self.accepted if isinstance(a, VariationStep)]

    def run(self, given_up: Callable[[Model], bool] = lambda _: False) -> None:
        """Search the heat, then the deformation, then look back.

        given_up : is the search to end at the best trial of the deformation, because another base model explains more?
        """
        self._forward(heat=True)
        self._begin_deformation()
        self._forward(heat=False, given_up=given_up)
        self._backward()
        self._finish()
        while self.steps and not _helped(self.steps[-1], self.options):
            self._drop(self.steps[-1], "worse")
            self._finish()

    def take_back(self, step: Step, reason: Objection) -> None:
        """Go on without an effect that was accepted, for a reason found when the search was over."""
        self._drop(step, reason)
        self._finish()

    def force(self, effect: Effect) -> Step:
        """Accept this effect, whatever the data say of it; the objection of the step's trial is what they do."""
        stages = [s for s in (*self._stages(heat=True), *self._stages(heat=False)) if effect in s.candidates]
        if not stages:
            raise LceError(f"{effect.name}: it changes nothing that these runs measured")
        trial = self.trials.of(effect, stages)
        step = self._step(trial, (effect.name,))
        mends = self._mends_the_drive(step)
        trial = replace(step.trial, objection="driven" if mends else self.trials.objection(step.trial))
        self._accept(replace(step, trial=trial))
        self._finish()
        (step,) = self.steps
        if not trial.objection and not _helped(step, self.options):
            step = replace(step, trial=replace(trial, objection="worse"))
        return step

    def varies(self) -> dict[str, Variation]:
        """What differs from run to run in the present model, with standard errors of the values of each run."""
        found = dict(self.present.model.varies)
        for stage in (*self.present.heat[:1], self.present.deformation):
            if stage is not None and stage.fit.problem.varying:
                problem = with_run_errors(stage.fit.problem)
                keys = {problem.model.values[problem.free[j]].key for j in problem.varying}
                # The part that has the last word on a parameter knows its error.
                found |= {key: v for key, v in problem.model.varies.items() if key in keys}
        return found

    def misfit(self, model: Model, drive: Drive, judged: JudgedRuns | None = None) -> Misfit:
        """Errors of a model simulated beside the runs, or others."""
        return (self.data.judged if judged is None else judged).misfit(self.whole(model), drive)

    def whole(self, model: Model) -> Model:
        """The model with all candidates at their null values, where they change nothing: it is compiled already."""
        return with_candidates(model, self.candidates)

    def _forward(self, heat: bool, given_up: Callable[[Model], bool] = lambda _: False) -> None:
        """Search one part of the model; what was found stays if it explains most of what was to be explained."""
        began = len(self.accepted)
        effects_left = True
        while len(self.steps) < self.options.max_effects:
            trials = self._far_reaching(heat) if effects_left else []
            effects_left = bool(trials)
            if given_up(self._best_of(trials)):
                for trial in (t for t in trials if not t.objection):
                    self.trials.reject(trial, "base")
                break
            found = self._next(trials, heat)
            if found is None:
                break
            self._accept(found)
        self._prune(began)
        self._drop_what_explains_a_part(began)
        if self._since(began, VariationStep) and not self._differences_explain(began):
            for variation in reversed(self._since(began, VariationStep)):
                without = self._refitted(_without_variation(self.present.model, variation.key))
                self._take_out(variation, without, partial(_without_variation, key=variation.key))
            self._drop_what_explains_a_part(began)

    def _drop_what_explains_a_part(self, began: int) -> None:
        """Take back effects of this part of the model, the last first, until the last explains most."""
        while (effects := self._since(began, Step)) and not self._explained(effects[-1]):
            self._drop(effects[-1], "part")
            self._prune(began)

    def _differences_explain(self, began: int) -> bool:
        """Do all parameters that differ from run to run together take most of what would be left without them?"""
        steps = self._since(began, VariationStep)
        kept = {key: v for key, v in self.present.model.varies.items() if key not in {s.key for s in steps}}
        without = self._refitted(self.present.model.varying(kept))
        before, after = (self.misfit(fit.model, self.present.drive) for fit in (without, self.present))
        return _explains(steps[-1], before, after, self.options)

    def _since(self, began: int, kind: type[Kind]) -> list[Kind]:
        """What was accepted since, of one kind."""
        return [a for a in self.accepted[began:] if isinstance(a, kind)]

    def _begin_deformation(self) -> None:
        """Where the heat has changed and much is left of the displacement, identify the deformation from scratch.

        It was identified behind another temperature, and may sit in a poor minimum.
        """
        if self.accepted and self.present.worst_behind_heat > self.options.near:
            anew = self._identified_anew(self.present)
            if anew is not None:
                self.accepted[-1] = replace(self.accepted[-1], with_it=anew)
                self.present = anew

    def _far_reaching(self, heat: bool) -> list[Trial]:
        """Trials of one part of the model, judged; none if no effect goes far."""
        trials = self.trials.judged(self._tried(heat))
        if not heat:
            trials = [*map(self._elsewhere, trials[:1]), *trials[1:]]
        if any(goes_far(trial, self.options) for trial in trials):
            return trials
        for trial in (t for t in trials if not t.objection):
            self.trials.reject(trial, "part")
        return []

    def _elsewhere(self, best: Trial) -> Trial:
        """The best trial where an identification from scratch ends, if only its strength spoke against it before.

        In a poor minimum the strength of the fit is not the one that the runs want.
        """
        if best.objection != "varies" or best.reduction < self.options.most:
            return best
        fit = self._refitted(self._with(best))
        found = (self._identified_anew(fit) or fit).deformation
        if found is None or not set(best.stage.channels) <= set(found.channels):
            return best
        return self.trials.judged_at(best, found.fit)

    def _best_of(self, trials: Sequence[Trial]) -> Model:
        """The model of the best trial that nothing speaks against; the present one without any."""
        best = next((t for t in trials if not t.objection), None)
        return self.present.model if best is None else self._with(best)

    def _with(self, trial: Trial) -> Model:
        """The present model with the effect of a trial, and the values that the trial found."""
        return carried(self.present.model.add(trial.effect), trial.fit.problem.model)

    def _next(self, trials: Sequence[Trial], heat: bool) -> Accepted | None:
        """The effect that passes, or the parameter that differs from run to run: whichever takes more of the error.

        What differs is looked for where a sensor is left beyond the noise, which one effect does not explain.
        """
        step = next((s for t in trials if not t.objection and (s := self._confirmed(t, trials))), None)
        if self._explains_all(self.present if step is None else step.with_it, heat):
            return step
        stages = self._stages(heat)[:1]
        variation = variation_trial(stages[0], self.left_out, self.options, self.progress) if stages else None
        if variation is None or (step is not None and step.trial.gain >= SIMPLER * variation.gain):
            return step
        return self._variation_step(variation)

    def _explains_all(self, fit: StagedFit, heat: bool) -> bool:
        """Does the model leave the sensors of a part within what counts as explained?"""
        left = [x for channel, x in fit.mean_squares.items() if not heat or channel is TEMPERATURE]
        return max(left, default=0.0) <= self.options.explained**2

    def _variation_step(self, trial: VariationTrial) -> VariationStep:
        found = trial.fit.problem.model
        model = carried(self.present.model.varying({**self.present.model.varies, trial.key: Variation()}), found)
        after = self._refitted(model)
        train, held_out = self._between(self.present, after, trial.held_out, after.drive)
        return VariationStep(self.present, after, train, held_out, trial)

    def _prune(self, began: int) -> None:
        """Take back what differs from run to run only because an effect was still missing.

        A run that does not begin at the ambient temperature of all has a start of its own. Where it has an ambient
        temperature of its own instead, taking that back makes nothing simpler, and it stays.
        """
        for step in [a for a in self.accepted[began:-1] if isinstance(a, VariationStep)]:
            without = self._refitted(_without_variation(self.present.model, step.key))
            part = step.trial.stage.part
            old, new = without.stage(part), self.present.stage(part)
            if old is None or new is None or old.fit.independent >= new.fit.independent:
                continue
            errors = self.left_out.errors(old, new.fit.problem, f"{step.key} of each run")
            if not on_data_left_out(step.trial.stage, errors, self.options):
                continue
            self._take_out(step, without, partial(_without_variation, key=step.key))

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
        start = start.varying({**start.varies, **best.fit.problem.model.varies})
        found = self._refitted(start)
        return found if reduction_of(self.present.mean_squares, found.mean_squares) >= self.options.far else None

    def _explained(self, last: Step) -> bool:
        """Does the last effect take most of what would be left without it?

        Where nothing differs from run to run, on data left out; else of the runs, with what differs on either side.
        Then it has to take most of the error of the runs held out as well.
        """
        if not self.present.model.varies:
            errors = last.held_out.errors
            return _explains(last, errors.judged_before, errors.judged_after, self.options)
        without = self._refitted(self.present.model.without(last.trial.effect.reference))
        before, after = (self.misfit(fit.model, self.present.drive) for fit in (without, self.present))
        stage = last.trial.stage
        tested = self.left_out.on_test_runs(stage, without.model, self.present.model)
        if tested is not None:
            errors = tested.errors
            if reduction(errors.judged_before, errors.judged_after, stage.channels) < self.options.most:
                return False
        return _explains(last, before, after, self.options)

    def _backward(self) -> None:
        """Take out what later additions have made superfluous."""
        for step in self.steps[:-1]:
            reference = step.trial.effect.reference
            without = self._refitted(self.present.model.without(reference))
            before, after = (self.misfit(fit.model, self.present.drive) for fit in (without, self.present))
            if any(before.mean_square(c) - after.mean_square(c) >= self.options.worth_noise for c in before.total):
                continue
            self.trials.reject(step.trial, "less")
            self._take_out(step, without, partial(Model.without, effect=reference))

    def _take_out(self, step: Accepted, present: StagedFit, change: Callable[[Model], Model]) -> None:
        """Go on without a step that was accepted; ``present`` is what all the others give."""
        # By its label: what was taken out before has left the later steps with fits of their own.
        place = [accepted.label for accepted in self.accepted].index(step.label)
        earlier, later = self.accepted[:place], self.accepted[place + 1 :]
        fits = [*(self._refitted(change(s.with_it.model)) for s in later[:-1]), present] if later else []
        before = [step.without, *fits[:-1]][: len(later)]
        self.accepted = [
            *earlier,
            *(replace(s, without=a, with_it=b) for s, a, b in zip(later, before, fits, strict=True)),
        ]
        self.present = present

    def _finish(self) -> None:
        """Refit what was accepted on every sample, and tell every step between the models that this gives."""
        fits = [self.base, *(self._refitted(a.with_it.model, every_sample=True) for a in self.accepted)]
        self.present = fits[-1]
        told: list[Accepted] = []
        for accepted, without, with_it in zip(self.accepted, fits[:-1], fits[1:], strict=True):
            train, held_out = self._between(without, with_it, accepted.held_out, self.present.drive)
            told.append(accepted.between(without, with_it, train, held_out))
        self.accepted = told

    def _refitted(self, model: Model, every_sample: bool = False) -> StagedFit:
        """The model refitted stage by stage, beside it the candidates that it lacks; a search takes a coarser grid."""
        left = [e for e in self.candidates if e.reference not in model.effects]
        if not every_sample:
            return refit_stages(model, self.coarse, left, self.options, self.progress)
        fewer = replace(self.options, iterations=min(self.options.iterations, FINE))
        return refit_stages(model, self.data, left, fewer, self.progress)

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
        """The step that accepts the effect; None if on the runs held out it does not help, or harms another sensor."""
        step = self._step(trial, self.trials.alias_set(trial, trials))
        if gets_worse(trial.stage, step.held_out, self.options):
            self.trials.reject(trial, "worse")
            return None
        tested = self.left_out.on_test_runs(trial.stage, self.present.model, step.with_it.model)
        if tested is not None and (reason := on_data_left_out(trial.stage, tested, self.options)):
            self.trials.reject(trial, reason)
            return None
        if self._mends_the_drive(step):
            self.trials.reject(trial, "driven")
            return None
        return step

    def _mends_the_drive(self, step: Step) -> bool:
        """Does the effect only mend what the measured temperature did to the deformation that it drives?

        So it is if the model as given explains more without it, driven by its own temperature: a camera that lags
        makes the strip look early.
        """
        if step.trial.stage.drive != "measured":
            return False
        own, (_, after) = self._given_misfit, step.train
        return all(own.mean_square(c) <= after.mean_square(c) for c in step.trial.stage.channels)

    @cached_property
    def _given_misfit(self) -> Misfit:
        return self.misfit(self.given, "model")

    def _step(self, trial: Trial, alias_set: tuple[str, ...]) -> Step:
        after = self._refitted(self._with(trial))
        if trial.stage.part != "heat" and after.worst_behind_heat > self.options.near:
            after, trial = self._searched_anew(after, trial)
        train, held_out = self._between(self.present, after, trial.held_out, after.drive)
        return Step(self.present, after, train, held_out, trial, alias_set)

    def _searched_anew(self, fit: StagedFit, trial: Trial) -> tuple[StagedFit, Trial]:
        """Where much is left, the deformation identified from scratch, with the effect; if that explains more."""
        anew = self._identified_anew(fit)
        if anew is None or anew.deformation is None:
            return fit, trial
        problem = anew.deformation.fit.problem
        return anew, replace(trial, held_out=self.left_out.errors(trial.stage, problem, trial.effect.name))

    def _identified_anew(self, present: StagedFit) -> StagedFit | None:
        """The model identified from scratch, its deformation driven as it is judged; None if that explains no more."""
        runs = [run_input.run for run_input in self.coarse.inputs]
        # Stage by stage, as the model is refitted then: both at once take most of the time of an identification.
        found = identify(present.model, runs, FitOptions(drive=present.drive, reweighted=0), self.progress)
        anew = self._refitted(found.model)
        return anew if anew.deformation is not None and anew.error <= present.error * (1.0 - BETTER) else None

    def _between(
        self, without: StagedFit, with_it: StagedFit, held_out: HeldOut | None, drive: Drive
    ) -> tuple[tuple[Misfit, Misfit], HeldOut]:
        """Errors of two models on the runs and on what was left out, the deformation driven in the same way."""
        train = self.misfit(without.model, drive), self.misfit(with_it.model, drive)
        assert held_out is not None
        if held_out.how == "test runs":
            models = self.whole(without.model), self.whole(with_it.model)
            held_out = replace(held_out, errors=self.tests.pair(*models, drive, SENSORS))
        return train, held_out

    def _accept(self, step: Accepted) -> None:
        self.accepted.append(step)
        self.present = step.with_it

    def _drop(self, step: Step, reason: Objection) -> None:
        """Take back an effect, refitting what was accepted after it."""
        reference = step.trial.effect.reference
        last = step is self.accepted[-1]
        present = step.without if last else self._refitted(self.present.model.without(reference))
        self.trials.reject(step.trial, reason)
        self._take_out(step, present, partial(Model.without, effect=reference))


def _without_variation(model: Model, key: str) -> Model:
    return model.varying({k: v for k, v in model.varies.items() if k != key})


def _explains(last: Accepted, before: Misfit, after: Misfit, options: DiagnoseOptions) -> bool:
    """Does the last change of a part of the model take most of what was left of the error of a sensor?

    If not, it stands in for something else, that the library or the base model lacks. A sensor that was at its noise
    before does not count: a joint refit moves the temperature a little, whatever the effect. Where the heat is not
    explained, and the measured temperature drives the deformation, the effect has to bring the displacement near its
    noise.
    """
    driven = last.trial.stage.drive == "measured"
    channels = (c for c in last.trial.stage.channels if c in before.total)
    for channel in (c for c in channels if before.above_noise(c) > options.worth_noise):
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
