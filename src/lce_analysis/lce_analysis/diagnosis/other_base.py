# SPDX-License-Identifier: Apache-2.0
"""Would another deformation model explain the displacement better?

Effects can mend a base model that has the wrong form, and are named for what is not there. So where the displacement
is left above its noise, the other physical base models are identified from the same runs, without effects of the
deformation. The most promising are searched for effects too, and what one leaves in the end is judged on the same data.
It is preferred as well if it leaves no more with fewer effects. Where the present model explains the displacement by
effects, only the quickest is identified, without any.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import itemgetter
from typing import Any, Final

from lce_analysis.diagnosis.accepted import Step
from lce_analysis.diagnosis.disturbed import signatures_left
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, Pair, share_removed
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.stage_problem import StagedFit
from lce_analysis.identification.identify import fit as identify
from lce_analysis.identification.stages import acts_on_temperature
from lce_analysis.options import DiagnoseOptions, FitOptions
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.errors import LceError
from lce_model import Model
from lce_model.effects import find

BASES: Final = ("equilibrium", "kinetic", "dynamic")
"""The physical deformation models, the quickest first."""
QUICKEST: Final = "equilibrium"
"""The one whose search takes a few seconds."""
SLOWEST: Final = "dynamic"
"""The one whose identification takes a search for the global minimum."""
QUICK: Final = FitOptions(time_constants=(), random_guesses=400, starts=4, reweighted=0, slow=5.0)
"""Of a fit that is to compare models, behind the present heat; one that is searched for effects is refitted first."""


@dataclass(frozen=True)
class OtherBase:
    """A deformation model that explains the displacement better.

    model : with what was found missing beside it, refitted.
    steps : the effects that were found missing beside it, in their order.
    effects : of the deformation, that the present model had.
    present, other : errors of the present model and of the other one, each with its effects, on the same runs, away
        from the jumps of both.
    runs : their names.
    jumps : whether there are any.
    """

    model: Model
    steps: tuple[Step, ...]
    effects: tuple[str, ...]
    present: Misfit
    other: Misfit
    runs: tuple[str, ...]
    jumps: bool

    @property
    def deformation(self) -> str:
        """Its name."""
        return self.model.deformation

    @property
    def added(self) -> list[str]:
        """Names of the effects that were found missing beside it."""
        return [step.added for step in self.steps]

    def as_json(self) -> dict[str, Any]:
        """How to identify it, what is missing beside it, RMS errors of the displacement in × noise, away from jumps."""
        return {
            "deformation": self.deformation,
            "effects": list(self.model.effects),
            "varies": list(self.model.varies),
            "added": self.added,
            "displacement": self.other.rms[DISPLACEMENT],
            "instead_of": self.present.rms[DISPLACEMENT],
            "runs": list(self.runs),
        }


class OtherBases:
    """The other base models beside one search, identified and searched when they are first asked for."""

    def __init__(self, search: Search) -> None:
        self._search = search

    def explain(self, model: Model) -> bool:
        """Does the best of them explain the displacement, where the best trial of the search does not?

        Where that does, only the quickest counts, if it leaves no more without any effect. This is only asked of the
        dynamic model: to identify that one from scratch beside every effect takes longer than all that is done here.
        """
        search, options = self._search, self._search.options
        measured = DISPLACEMENT in search.present.mean_squares
        if model.deformation != SLOWEST or not measured or search.present.drive == "measured":
            return False
        before = _before_deformation(search).model
        if _explains(_errors(search, before, model), options):
            return model is not search.present.model and self._quickest_does_as_well(before, model)
        if not self._begin_well:
            return False
        other, steps = self._found
        pair = _errors(search, model, other)
        return _explains(pair, options, steps) and _leaves_less(pair, options)

    def better(self) -> OtherBase | None:
        """The best of them; None if none leaves clearly less, or as little with fewer effects."""
        search, options = self._search, self._search.options
        present = search.present
        if present.drive == "measured":
            return None
        found: tuple[Model, tuple[Step, ...]] | None
        if present.mean_squares.get(DISPLACEMENT, 0.0) <= options.compared_from**2:
            # Where effects of the deformation explain the displacement, only the quickest may do without them.
            found = (self._quickest, ()) if deformation_steps(search) and self._quickest else None
        else:
            found = self._found if self._begin_well else None
        if found is None:
            return None
        model, steps = found
        pair = _errors(search, present.model, model)
        if steps and not _explains(pair, options, steps):
            # Too much is left to name an effect; the other form may be worth having by itself.
            model, steps = steps[0].without.model, ()
            pair = _errors(search, present.model, model)
        simpler = len(steps) < len(deformation_steps(search)) and _leaves_no_more(pair, options)
        if not simpler and not _leaves_less(pair, options):
            return None
        names = tuple(run.name for run in _judged(search).runs)
        away, every = pair.judged_after.samples[DISPLACEMENT].sum(), pair.after.samples[DISPLACEMENT].sum()
        judged = pair.judged_before, pair.judged_after
        return OtherBase(model, steps, tuple(_names(present.model)), *judged, names, bool(away < every))

    def _quickest_does_as_well(self, before: Model, model: Model) -> bool:
        """Does the quickest, without effects, do what a model does that has more of them than the one before?"""
        options = self._search.options
        if self._quickest is None:
            return False
        instead, beside = (_errors(self._search, one, self._quickest) for one in (before, model))
        return _explains(instead, options) and _leaves_less(instead, options) and _leaves_no_more(beside, options)

    @cached_property
    def _quickest(self) -> Model | None:
        """The quickest of them without effects of the deformation; None if the present model is of that form."""
        return _identified(QUICKEST, self._search)

    @cached_property
    def _begin_well(self) -> list[Model]:
        """Those worth a search, without effects of the deformation: the one that leaves least, and what comes close.

        What is missing may look like the wrong form, as a transition that takes time looks like the kinetic model. The
        slow one is searched only if it leaves least; the quickest always, the last if it begins badly.
        """
        search = self._search
        others = [model for name in BASES if (model := _identified(name, search)) is not None]
        left = [_left(search, model) for model in others]
        least = min(left, default=0.0)
        limit = search.options.other_begins * min(least, _left(search, _before_deformation(search).model))
        close = [(other, x) for other, x in zip(others, left, strict=True) if x <= limit]
        well = [other for other, x in close if x == least or other.deformation != SLOWEST]
        return well + [other for other in others if well and other.deformation == QUICKEST and other not in well]

    @cached_property
    def _found(self) -> tuple[Model, tuple[Step, ...]]:
        """The first that explains the displacement with what it lacks, or else the one that leaves least; its steps."""
        search = self._search
        own = _before_deformation(search).model
        found: list[tuple[float, Model, tuple[Step, ...]]] = []
        for begun in self._begin_well:
            model, steps = self._searched(begun)
            pair = _errors(search, own, model)
            found.append((pair.judged_after.mean_square(DISPLACEMENT), model, steps))
            if _explains(pair, search.options, steps):
                break
        _, model, steps = min(found, key=itemgetter(0))
        return model, steps

    def _searched(self, model: Model) -> tuple[Model, tuple[Step, ...]]:
        """A base model with what it lacks, and the steps that found that.

        One effect has to bring it near the noise, or to take nearly all of the error: another form and several effects
        are too many guesses at once.
        """
        search, options = self._search, self._search.options
        begun = _left(search, model)
        if begun <= options.compared_from**2:
            return model, ()
        enough = max(options.near**2, begun * (1.0 - options.nearly_all))
        found = _search_beside(model, search, lambda trial: _left(search, trial) > enough)
        return found.present.model, tuple(found.steps)


def _before_deformation(search: Search) -> StagedFit:
    """The present model as it was before an effect of the deformation was added."""
    return next((step.without for step in deformation_steps(search)), search.present)


def deformation_steps(search: Search) -> list[Step]:
    """The effects of the deformation that were added."""
    return [step for step in search.steps if not acts_on_temperature(step.trial.effect)]


def _identified(deformation: str, search: Search) -> Model | None:
    """Another base model behind the present heat; None if it is the same, or these runs cannot identify it."""
    present = search.present.model
    if deformation == present.deformation:
        return None
    behind = [e for e in present.effects if not acts_on_temperature(find(e))]
    other = reduce(Model.without, behind, present).deformed_by(deformation)
    runs = search.data.judged.runs
    try:
        found = identify(other, runs, QUICK, search.progress)
    except LceError:
        return None
    if found.interrupted:
        raise KeyboardInterrupt
    return found.model if found.model.predicts(DISPLACEMENT) else None


def _search_beside(model: Model, search: Search, given_up: Callable[[Model], bool]) -> Search:
    """The same runs, searched for what another base model lacks; of the heat only where that is not explained.

    A form that needs values of its own for each run is no better one, so its parameters are one for all.
    """
    heat = search.present.mean_squares.get(TEMPERATURE, 0.0) > search.options.explained**2
    own = [effect for effect in search.candidates if heat or not acts_on_temperature(effect)]
    left = [effect for effect in own if effect.reference not in model.effects]
    found = Search(model, search.data.judged.runs, search.tests.runs, left, search.options, search.progress)
    found.run(given_up, may_differ=False)
    if found.steps:
        signatures_left(found)  # an effect that lives on a disturbance is taken back
    return found


def _judged(search: Search) -> JudgedRuns:
    """The runs held out; without a displacement in any, the runs themselves."""
    held_out = any(DISPLACEMENT in run.series for run in search.tests.runs)
    return search.tests if held_out else search.data.judged


def _errors(search: Search, first: Model, second: Model) -> Pair:
    """Errors of the displacement of two models."""
    models = search.whole(first), search.whole(second)
    return _judged(search).pair(*models, search.present.drive, [DISPLACEMENT])


def _left(search: Search, model: Model) -> float:
    """Mean squared error of the displacement in units of the noise, away from jumps."""
    away = _judged(search).away_from_jumps(search.whole(model), search.present.drive)
    return away.mean_square(DISPLACEMENT)


def _explains(pair: Pair, options: DiagnoseOptions, steps: Sequence[Step] = ()) -> bool:
    """Does the second model leave the displacement at its noise, or near it and hardly anything of the error before?

    Another form with effects of its own has to leave it at its noise: that is more than one guess at once.
    """
    left = pair.judged_after.mean_square(DISPLACEMENT)
    nearly_all = share_removed(pair.judged_before, pair.judged_after, DISPLACEMENT) >= options.nearly_all
    return left <= options.explained**2 or (not steps and nearly_all and left <= options.near**2)


def _leaves_less(pair: Pair, options: DiagnoseOptions) -> bool:
    """Does the second model leave clearly less above the noise?"""
    before, after = (misfit.above_noise(DISPLACEMENT) for misfit in (pair.judged_before, pair.judged_after))
    return after < options.other_base * before


def _leaves_no_more(pair: Pair, options: DiagnoseOptions) -> bool:
    """Does the second model leave as little, but for what is not worth having?"""
    before, after = (misfit.above_noise(DISPLACEMENT) for misfit in (pair.judged_before, pair.judged_after))
    return after <= before + options.worth_noise


def _names(model: Model) -> Iterator[str]:
    """Names of the effects behind the heat."""
    for reference, name in zip(model.effects, model.effect_names, strict=True):
        if not acts_on_temperature(find(reference)):
            yield name
