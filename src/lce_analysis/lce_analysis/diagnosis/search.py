# SPDX-License-Identifier: Apache-2.0
"""Forward and backward through the library, stage by stage: try the likeliest, keep what is worth having.

The heat is searched first, on the temperature alone; then the deformation. In each step the effects of the library
compete with the parameters of the base model that may differ from run to run. The search of a stage ends when nothing
more passes; then everything that was accepted has to prove itself once more beside the rest.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Final

from lce_analysis.diagnosis.accepted import Accepted, Step, VariationStep
from lce_analysis.diagnosis.chain import Chain
from lce_analysis.diagnosis.linearized_fit import gained
from lce_analysis.diagnosis.looking_back import (
    bends_the_heat,
    keep_what_explains,
    not_borne_out,
    take_back_refuted,
    take_back_superfluous,
)
from lce_analysis.diagnosis.misfit import Misfit, reduction_of
from lce_analysis.diagnosis.stage_problem import StagedFit, StageProblem, carried
from lce_analysis.diagnosis.strength import strengths_of
from lce_analysis.diagnosis.trial import (
    Trial,
    gets_worse,
    goes_far,
    on_data_left_out,
    reach,
    stands_at_a_bound,
    untouched_by,
)
from lce_analysis.diagnosis.variation import VariationTrial, variation_trial
from lce_data.channels import TEMPERATURE
from lce_data.errors import LceError
from lce_model import Model, Variation
from lce_model.effects import Effect

RESTARTS: Final = 2
"""Times that a base caught in a poor minimum is refitted from elsewhere."""
SURPRISE: Final = 1.5
"""A trial that gains so many times what was predicted may have left a poor minimum of the base."""
SIMPLER: Final = 0.9
"""An effect that takes this share of what a value for each run takes is preferred: it is one number, not as many."""


class _Moved(Exception):
    """The present model has left a poor minimum: what was tried beside it there says nothing any more."""


class Search(Chain):
    """A chain that grows by what is worth having, and looks back at the end of each part of the model."""

    def run(self, given_up: Callable[[Model], bool] = lambda _: False, may_differ: bool = True) -> None:
        """Search the heat, then the deformation, then look back.

        given_up : is the search to end at the best trial of the deformation, because another base model explains more?
        may_differ : may parameters of the deformation be found to differ from run to run?
        """
        self._forward(heat=True)
        if self.accepted:
            # The deformation was identified behind another temperature.
            self._leaves_poor_minimum()
        self._forward(heat=False, given_up=given_up, may_differ=may_differ)
        if self.of_part(False, VariationStep):
            # What was found to differ beside the displacement may do what an effect of the heat seemed to.
            for heat in (True, False):
                keep_what_explains(self, heat)
        take_back_superfluous(self)
        self.finish()
        take_back_refuted(self)

    def force(self, effect: Effect) -> Step:
        """Accept this effect, whatever the data say of it; the objection of the step's trial is what they do."""
        stages = [s for s in (*self._stages(heat=True), *self._stages(heat=False)) if effect in s.candidates]
        if not stages:
            raise LceError(f"{effect.name}: it changes nothing that these runs measured")
        trial = self.trials.of(effect, stages)
        try:
            step = self._step(trial, (effect.name,))
        except _Moved:
            return self.force(effect)
        mends = self._mends_the_drive(step)
        trial = replace(step.trial, objection="driven" if mends else self.trials.objection(step.trial))
        self.accept(replace(step, trial=trial))
        self.finish()
        (step,) = self.steps
        if not trial.objection:
            step = replace(step, trial=replace(step.trial, objection=not_borne_out(step, self.options)))
        return step

    def accept_trial(self, trial: Trial, alias_set: tuple[str, ...]) -> None:
        """Accept a trial that passed another test than those of this search."""
        self.accept(self._step(replace(trial, objection=""), alias_set, anew=False))
        self.finish()

    def _forward(
        self, heat: bool, given_up: Callable[[Model], bool] = lambda _: False, may_differ: bool = True
    ) -> None:
        """Search one part of the model; what was found stays if it explains most of what was to be explained.

        If nothing of it does, it is searched again without the effect that was found first, as long as another one took
        most of the error from the same beginning. What is found then fitted worse at first: it stays only if it leaves
        nothing unexplained.
        """
        while len(self.trials.set_aside) < self.options.contenders:
            replaceable = self._added(heat, given_up, may_differ)
            keep_what_explains(self, heat)
            if self.trials.set_aside and not self._explains_all(self.present, heat):
                for step in reversed(self.of_part(heat, Step)):
                    self.drop(step, "part")
            if not replaceable or self.of_part(heat, Step):
                break
            self.trials.set_aside.add(replaceable)
        self.trials.set_aside.clear()

    def _added(self, heat: bool, given_up: Callable[[Model], bool], may_differ: bool) -> str:
        """Add to one part of the model whatever passes; the name of the first effect if another could have been it."""
        effects_left, replaceable = True, ""
        while len(self.of_part(heat, Step)) < self.options.max_effects:
            try:
                trials, anew = self._far_reaching(heat) if effects_left else ([], False)
                passing = any(not trial.objection for trial in trials)
                if not (heat or passing or self.accepted) and self._leaves_poor_minimum():
                    continue
                effects_left = bool(trials)
                if given_up(self._best_of(trials)):
                    for trial in (t for t in trials if not t.objection):
                        self.trials.reject(trial, "base")
                    break
                found = self._next(trials, heat, may_differ, anew)
            except _Moved:
                continue
            if found is None:
                break
            if isinstance(found, Step) and not self.of_part(heat, Step):
                replaceable = found.added if self._take_most(trials, besides=found.added) else ""
            self.accept(found)
        return replaceable

    def _take_most(self, trials: Sequence[Trial], besides: str) -> bool:
        """Does another effect, which nothing speaks against, take most of the error by itself as well?"""
        others = (t for t in trials if t.effect.name != besides and t.objection in ("", "less"))
        return any(trial.reduction >= self.options.most for trial in others)

    def _leaves_poor_minimum(self) -> bool:
        """Where much is left of the displacement, go on from an identification from scratch, if that explains more."""
        anew = self.identified_anew(self.present) if self.present.worst_behind_heat > self.options.near else None
        if anew is not None:
            self.move(anew)
            self.trials.forget_behind_heat()
        return anew is not None

    def _far_reaching(self, heat: bool) -> tuple[list[Trial], bool]:
        """Trials of one part of the model, judged; none if no effect goes far.

        Also whether an identification from scratch is still worth its time in this step.
        """
        trials, anew = self.trials.judged(self._tried(heat)), True
        if not heat and trials and self._wants_another_strength(trials[0]):
            trials, anew = [self._elsewhere(trials[0]), *trials[1:]], False
        if any(goes_far(trial, self.options) for trial in trials):
            return trials, anew
        for trial in (t for t in trials if not t.objection):
            self.trials.reject(trial, "part")
        return [], False

    def _wants_another_strength(self, best: Trial) -> bool:
        """Does only its strength speak against a trial? In a poor minimum that is not the one that the runs want."""
        return best.objection == "varies" and goes_far(best, self.options)

    def _elsewhere(self, best: Trial) -> Trial:
        """The trial where an identification from scratch ends."""
        fit = self.refitted(self.with_effect_of(best))
        found = (self._identified_with_effect(fit) or fit).deformation
        if found is None or not set(best.stage.channels) <= set(found.channels):
            return best
        return self.trials.judged_at(best, found.fit)

    def _best_of(self, trials: Sequence[Trial]) -> Model:
        """The model of the best trial that nothing speaks against; the present one without any."""
        best = next((t for t in trials if not t.objection), None)
        return self.present.model if best is None else self.with_effect_of(best)

    def _next(self, trials: Sequence[Trial], heat: bool, may_differ: bool, anew: bool) -> Accepted | None:
        """The effect that passes, or the parameter that differs from run to run: whichever takes more of the error.

        What differs is looked for where a sensor is left beyond the noise, which one effect does not explain.
        """
        step = None
        for trial in self._in_their_order(trials):
            step, anew = self._confirmed(trial, trials, anew), False
            if step is not None:
                break
        if not may_differ or self._explains_all(self.present if step is None else step.with_it, heat):
            return step
        stages = self._stages(heat)[:1]
        variation = variation_trial(stages[0], self.left_out, self.options, self.progress) if stages else None
        if variation is None or (step is not None and step.trial.gain >= SIMPLER * variation.gain):
            return step
        return self._variation_step(variation)

    def _in_their_order(self, trials: Sequence[Trial]) -> list[Trial]:
        """Trials that nothing speaks against, the best first; where that is at a bound, first those that do the same.

        So softening at the end of its range is a straight line, which thermal expansion is anywhere in its own.
        """

        def bound(trial: Trial) -> bool:
            return stands_at_a_bound(trial.fit.problem.model, trial.effect)

        passing = [t for t in trials if not t.objection]
        if not passing or not bound(passing[0]):
            return passing
        alike = self.trials.alias_set(passing[0], trials)
        return sorted(passing, key=lambda trial: trial.effect.name not in alike or bound(trial))

    def _explains_all(self, fit: StagedFit, heat: bool) -> bool:
        """Does the model leave the sensors of a part within what counts as explained?"""
        left = [x for channel, x in fit.mean_squares.items() if not heat or channel is TEMPERATURE]
        return max(left, default=0.0) <= self.options.explained**2

    def _variation_step(self, trial: VariationTrial) -> VariationStep:
        found = trial.fit.problem.model
        model = carried(self.present.model.varying({**self.present.model.varies, trial.key: Variation()}), found)
        after = self.refitted(model)
        train, held_out = self.between(self.present, after, trial.held_out, after.drive)
        return VariationStep(self.present, after, train, held_out, trial)

    def _tried(self, heat: bool) -> list[Trial]:
        """Trials of one part of the model; the base moves first where they show a better minimum."""
        trials = self.trials.likely(self._stages(heat))
        for _ in range(RESTARTS):
            surprising = [t for t in trials if t.gain > SURPRISE * t.score.predicted_gain]
            if not surprising or not self._moves_to(surprising[0].fit.problem.model):
                break
            trials = self.trials.likely(self._stages(heat))
        return trials

    def _moves_to(self, other: Model) -> bool:
        """Go on from the present model refitted from the values of another one, if that explains far more.

        Then it was in a poor minimum. A sign of it is a trial that gains far more than was predicted, or far more where
        an identification from scratch ends.
        """
        found = self.refitted(carried(self.present.model, other))
        better = reduction_of(self.present.mean_squares, found.mean_squares) >= self.options.far
        if better:
            self.move(found)
        return better

    def _identified_with_effect(self, fit: StagedFit) -> StagedFit | None:
        """The model with an effect identified from scratch, if that explains more.

        Raises _Moved if the present model, without the effect, explains far more from there as well.
        """
        found = self.identified_anew(fit)
        if found is not None and self._moves_to(found.model):
            raise _Moved
        return found

    def _stages(self, heat: bool) -> tuple[StageProblem, ...]:
        if heat:
            return self.present.heat
        return () if self.present.deformation is None else (self.present.deformation,)

    def _confirmed(self, trial: Trial, trials: Sequence[Trial], anew: bool) -> Step | None:
        """The step that accepts the effect; None if on the runs held out it does not help, or harms another sensor.

        anew : may the deformation be identified from scratch? That takes longest, and is for the best trial.
        """
        step = self._step(trial, self.trials.alias_set(trial, trials), anew)
        stage, untouched, options = trial.stage, untouched_by(trial.effect), self.options
        if gets_worse(stage, step.held_out, options, untouched) or bends_the_heat(step, options):
            self.trials.reject(trial, "worse")
            return None
        tested = self.left_out.on_test_runs(stage, self.present.model, step.with_it.model)
        if tested is not None and (reason := on_data_left_out(stage, tested, options, untouched)):
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

    def _step(self, trial: Trial, alias_set: tuple[str, ...], anew: bool = True) -> Step:
        after = self.refitted(self.with_effect_of(trial))
        behind_heat = trial.stage.part != "heat"
        if anew and behind_heat and after.worst_behind_heat > self.options.explained and self._may_be_all(trial):
            after, trial = self._searched_anew(after, trial)
        train, held_out = self.between(self.present, after, trial.held_out, after.drive)
        return Step(self.present, after, train, held_out, trial, alias_set)

    def _may_be_all(self, trial: Trial) -> bool:
        """Might the effect be all that is missing behind the heat? It is the first found, or takes most of the rest.

        Where more is missing an identification from scratch leads no further, and it takes longest of all. For an
        effect that was refused once it is not worth its time again.
        """
        if trial.effect.name in self.trials.refused:
            return False
        return not self.of_part(False, Step) or reach(trial, self.options) >= self.options.most

    def _searched_anew(self, fit: StagedFit, trial: Trial) -> tuple[StagedFit, Trial]:
        """Where much is left, the deformation identified from scratch, with the effect; if that explains more."""
        anew = self._identified_with_effect(fit)
        if anew is None or anew.deformation is None or not set(trial.stage.channels) <= set(anew.deformation.channels):
            return fit, trial
        found = anew.deformation.fit
        held_out = self.left_out.errors(trial.stage, found.problem, trial.effect.name)
        strengths = strengths_of(found, trial.effect)
        return anew, replace(
            trial, fit=found, gain=gained(trial.stage.fit, found), strengths=strengths, held_out=held_out
        )
