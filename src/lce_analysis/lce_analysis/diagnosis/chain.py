# SPDX-License-Identifier: Apache-2.0
"""A base model and the changes accepted one after the other, each model refitted beside the same runs.

A change can be taken back; those accepted after it are then refitted without it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final, TypeVar

from lce_analysis.diagnosis.accepted import Accepted, Change, Step, VariationStep
from lce_analysis.diagnosis.held_out import DataLeftOut, HeldOut
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, Pair
from lce_analysis.diagnosis.stage_problem import Data, Part, StagedFit, carried, refit_stages, with_candidates
from lce_analysis.diagnosis.trial import Objection, Trial
from lce_analysis.diagnosis.trials import Trials
from lce_analysis.identification.coarse import FINER_S, STEP_S
from lce_analysis.identification.identify import check_runs, rough_fit
from lce_analysis.identification.random_effects import with_run_errors
from lce_analysis.options import DiagnoseOptions, Drive, FitOptions
from lce_analysis.prediction import MECHANICAL, simulation_input, with_ambient_at_rest
from lce_data.channels import SENSORS
from lce_data.errors import LceError
from lce_data.progress import Progress
from lce_data.run import Run
from lce_model import Model, Variation
from lce_model.effects import Effect

Kind = TypeVar("Kind", bound=Change)
FINE: Final = 15
"""Iterations of a refit on every sample, at most: it begins at the optimum of the finer grid, close to its own."""
CLOSE, FURTHER = 1.2, 60
"""One that leaves more than so many times the error of the finer grid was not close: it has so many iterations more."""
OTHER_STARTS: Final = (1, 2)
"""Seeds of identifications from scratch: from the starts of `lce fit`, which has 0, it would end where that did."""
BETTER: Final = 0.02
"""Share of the squared error by which another minimum must be better."""


class Chain:
    """The present model beside the runs, and what has been accepted so far.

    given : the model before any refit.
    base, present : the model refitted without any addition, and with what has been accepted.
    accepted : what has been accepted, in its order: effects, and parameters that differ from run to run.
    bearing : names of effects that take most beside the others that were found, whether these have been kept or not.
    free_forms : errors of data left out without and with an effect, beside free curves in the place of the base
        model's forms, of what was found by these.
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
        deformed = [run for run in (*runs, *test_runs) if any(c in MECHANICAL for c in run.measured)]
        drivable = all(run.temperature is not None for run in deformed)
        self.data = Data(JudgedRuns.of(runs), tuple(simulation_input(r, model) for r in runs), drivable=drivable)
        self.coarse, self.finer = self.data.coarse(STEP_S), self.data.coarse(FINER_S)
        self.tests = JudgedRuns.of(test_runs)
        self.left_out = DataLeftOut(self.data.judged, self.tests, progress)
        self.trials = Trials(len(self.candidates), self.left_out, options, progress)
        self.accepted: list[Accepted] = []
        self.bearing: set[str] = set()
        self.free_forms: dict[str, HeldOut] = {}
        self._finished: list[StagedFit] = []
        self.present = self.refitted(model)
        self.base = self._no_worse(model, self._on_every_sample(self.present.model))

    @property
    def steps(self) -> list[Step]:
        """The effects accepted."""
        return [a for a in self.accepted if isinstance(a, Step)]

    @property
    def variations(self) -> list[VariationStep]:
        """The parameters found to differ from run to run."""
        return [a for a in self.accepted if isinstance(a, VariationStep)]

    def of_part(self, heat: bool, kind: type[Kind]) -> list[Kind]:
        """What was accepted of one kind, found in the heat or behind it."""
        return [a for a in self.accepted if isinstance(a, kind) and (a.trial.stage.part == "heat") is heat]

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

    def of_the_runs(self, without: Model) -> Pair:
        """Errors in the runs of another model and of the present one, beside each other."""
        models = self.whole(without), self.whole(self.present.model)
        return self.data.judged.pair(*models, self.present.drive, SENSORS)

    def whole(self, model: Model) -> Model:
        """The model with all candidates at their null values, where they change nothing: it is compiled already."""
        return with_candidates(model, self.candidates)

    def with_effect_of(self, trial: Trial) -> Model:
        """The present model with the effect of a trial, and the values that the trial found."""
        return carried(self.present.model.add(trial.effect), trial.fit.problem.model)

    def refitted(self, model: Model) -> StagedFit:
        """The model refitted stage by stage on the grid of the search, beside it the candidates that it lacks."""
        return self._refitted(model, self.coarse, self.options.iterations)

    def _refitted(self, model: Model, data: Data, iterations: int) -> StagedFit:
        left = [e for e in self.candidates if e.reference not in model.effects]
        options = replace(self.options, iterations=min(self.options.iterations, iterations))
        return refit_stages(model, data, left, options, self.progress)

    def refitted_part(self, model: Model, part: Part) -> StagedFit:
        """The model refitted as far as a part of it is judged: for the heat alone, what is behind it stays as it is."""
        if part != "heat":
            return self.refitted(model)
        left = [e for e in self.candidates if e.reference not in model.effects]
        return refit_stages(model, self.coarse, left, self.options, self.progress, heat_alone=True)

    def _on_every_sample(self, model: Model) -> StagedFit:
        """What a search found, refitted on a finer grid and then on every sample.

        The finer grid leaves out what it does not resolve, so the optimum of every sample may lie farther away.
        """
        found = self._refitted(model, self.finer, self.options.iterations)
        fine = self._refitted(found.model, self.data, FINE)
        if fine.error > CLOSE * found.error:
            fine = self._refitted(fine.model, self.data, FURTHER)
        return fine

    def identified_anew(self, present: StagedFit) -> StagedFit | None:
        """The deformation identified from scratch behind the present heat; None if that explains no more.

        From the runs as recorded, driven as it is judged: with fewer samples of a fast movement another minimum may be
        the best. It is identified once more where the first starts ended worse: where they end as well, from elsewhere,
        the present minimum is no poor one.
        """
        runs = self.data.judged.runs
        for seed in OTHER_STARTS:
            options = FitOptions(drive=present.drive, time_constants=(), seed=seed)
            found = self.refitted(rough_fit(present.model, runs, options, self.progress))
            # Once more, without the samples around the jumps of what was found.
            anew = self.refitted(found.model)
            better = anew.deformation is not None and anew.error <= present.error * (1.0 - BETTER)
            if better or anew.error <= present.error * (1.0 + BETTER):
                return anew if better else None
        return None

    def between(
        self, without: StagedFit, with_it: StagedFit, held_out: HeldOut | None, drive: Drive
    ) -> tuple[tuple[Misfit, Misfit], HeldOut]:
        """Errors of two models on the runs and on what was left out, the deformation driven in the same way."""
        train = self.misfit(without.model, drive), self.misfit(with_it.model, drive)
        assert held_out is not None
        if held_out.how == "test runs":
            models = self.whole(without.model), self.whole(with_it.model)
            held_out = replace(held_out, errors=self.tests.pair(*models, drive, SENSORS))
        return train, held_out

    def accept(self, step: Accepted) -> None:
        """Go on with a change."""
        self.accepted.append(step)
        self.present = step.with_it

    def move(self, better: StagedFit) -> None:
        """Go on from a better minimum of the present model; what was added since the base, or the base, is in it."""
        if self.accepted:
            self.accepted[-1] = replace(self.accepted[-1], with_it=better)
        else:
            base = self._no_worse(self.given, self._on_every_sample(better.model))
            self.base = min(self.base, base, key=lambda fit: fit.error)
        self.present = better

    def drop(self, step: Step, reason: Objection) -> None:
        """Take back an effect, refitting what was accepted after it."""
        reference = step.trial.effect.reference
        last = step.label == self.accepted[-1].label
        present = step.without if last else self.refitted(self.present.model.without(reference))
        self.trials.reject(step.trial, reason)
        self.bearing.discard(step.added)
        self.take_out(step, present, partial(Model.without, effect=reference))

    def take_out(self, step: Accepted, present: StagedFit, change: Callable[[Model], Model]) -> None:
        """Go on without a step that was accepted; ``present`` is what all the others give."""
        # By its label: what was taken out before has left the later steps, this one as well, with fits of their own.
        place = [accepted.label for accepted in self.accepted].index(step.label)
        earlier, later = self.accepted[:place], self.accepted[place + 1 :]
        fits = [*(self.refitted(change(s.with_it.model)) for s in later[:-1]), present] if later else []
        before = [self.accepted[place].without, *fits[:-1]][: len(later)]
        self.accepted = [
            *earlier,
            *(self._moved(s, a, b) for s, a, b in zip(later, before, fits, strict=True)),
        ]
        self.present = present

    def _moved(self, step: Accepted, without: StagedFit, with_it: StagedFit) -> Accepted:
        """A step between two other models, judged on what is left out beside these."""
        moved, part = replace(step, without=without, with_it=with_it), step.trial.stage.part
        old, new = without.stage(part), with_it.stage(part)
        if old is None or new is None or old.channels != new.channels:
            return moved
        return replace(moved, held_out=self.left_out.errors(old, new.fit.problem, step.label))

    def finish(self) -> None:
        """Refit what was accepted on every sample, and tell every step between the models that this gives."""
        done = {id(fit) for fit in self._finished}
        with_it = [a.with_it for a in self.accepted]
        fits = [self.base, *(f if id(f) in done else self._on_every_sample(f.model) for f in with_it)]
        self.present, self._finished = fits[-1], fits
        told: list[Accepted] = []
        for accepted, without, after in zip(self.accepted, fits[:-1], fits[1:], strict=True):
            told.append(self._told(accepted, without, after))
        self.accepted = told

    def _told(self, accepted: Accepted, without: StagedFit, with_it: StagedFit) -> Accepted:
        """A change between two models, judged on what is left out beside these."""
        train, held_out = self.between(without, with_it, accepted.held_out, self.present.drive)
        told = accepted.between(without, with_it, train, held_out)
        if not isinstance(told, Step):
            return told
        stage, problem = told.trial.stage, told.trial.fit.problem
        if self.left_out.how(stage, problem) == held_out.how:
            return told
        # What differed from run to run when the effect was accepted has been taken out since.
        held_out = self.left_out.errors(stage, problem, told.added)
        return told.between(without, with_it, *self.between(without, with_it, held_out, self.present.drive))

    def _no_worse(self, given: Model, refitted: StagedFit) -> StagedFit:
        """The refit, or the model as given where no sensor has gained by it: the jumps may lie better there."""
        before, after = (self.misfit(model, refitted.drive) for model in (given, refitted.model))
        gained = any(after.mean_square(c) < before.mean_square(c) for c in before.total)
        return refitted if gained else replace(refitted, model=given)
