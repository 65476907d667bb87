# SPDX-License-Identifier: Apache-2.0
"""One effect added to a model: refitted with it, the error before and after."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from lce_analysis.diagnosis.diagnosis import ErrorTable, bounds_reached, columns, error_table, errors
from lce_analysis.diagnosis.held_out import HeldOut
from lce_analysis.diagnosis.ranking import reason
from lce_analysis.diagnosis.search import Search
from lce_analysis.diagnosis.strength import Estimate
from lce_analysis.diagnosis.words import outcome
from lce_analysis.identification.at_bounds import AtBound
from lce_analysis.identification.result import FitResult
from lce_analysis.inputs import lacks
from lce_analysis.options import DiagnoseOptions, FitOptions
from lce_data.errors import LceError
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect, find, library
from lce_model.terms import Parameter

KEPT: Final = frozenset({"thermal", "deformation", "effects", "train", "test", "verdict"})
"""What a model file keeps of each model tried."""


@dataclass(frozen=True)
class Addition:
    """A model refitted to the same runs without and with one more effect.

    Attributes
    ----------
    effect : name of the effect.
    given, before : the model as given, and refitted without the effect.
    model : with the effect, standard errors, and the record of the fit; ``model.fit["history"]`` is a table of the
        models tried, one mapping each, the oldest first.
    predicted_reduction, actual_reduction : of the squared error above the noise, as fractions.
    held_out : errors without and with the effect on data left out.
    strength_by_run : strength that each run alone would want; None where it says nothing.
    amplitude : the parameter that is reported as the strength.
    objection : why the data do not confirm the effect, in words; empty if they do.
    train, test : errors of the three models on the runs, and on those held out.
    at_bounds : parameters that the refit with the effect has left at a bound.
    """

    effect: str
    given: Model
    before: Model
    model: Model
    predicted_reduction: float
    actual_reduction: float
    held_out: HeldOut
    strength_by_run: Mapping[str, Estimate | None]
    amplitude: Parameter
    objection: str
    train: ErrorTable
    test: ErrorTable
    at_bounds: tuple[AtBound, ...] = ()

    @property
    def confirmed(self) -> bool:
        """Did it really help, on data left out as well?"""
        return not self.objection

    @property
    def sentence(self) -> str:
        """What adding it did."""
        return (
            f"With {self.effect} {self.actual_reduction:.1%} of the squared error above the noise goes "
            f"({self.predicted_reduction:.1%} was predicted); {outcome(self.held_out, self.objection)}."
        )


def add_effect(
    model: Model,
    effect: str | Effect,
    runs: Sequence[Run],
    test_runs: Sequence[Run] = (),
    options: DiagnoseOptions = DiagnoseOptions(),
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Addition:
    """Add an effect to a model, refit everything to all runs, and keep the record.

    The effect is added whether it helps or not: ``Addition.confirmed`` says what the data say of it.

    Parameters
    ----------
    model : to which it is added.
    effect : a name of the library, the path of an effect file, or an effect (with other bounds than its own).
    runs : what the model is fitted to.
    test_runs : held out; they decide whether the effect is confirmed. Without them each run is left out
        in turn, or, with one run or with values of its own for each, each fifth of every run.
    options : when an effect counts as confirmed.
    progress : called after each step.
    cancel : stops between two steps and raises Cancelled.

    Returns
    -------
    Addition
        The model before and after, and the reduction of the error.

    Raises
    ------
    LceError
        If the model has the effect already, or the runs do not hold what the model needs.

    Examples
    --------
    >>> import lce_analysis as lce
    >>> found = lce.add_effect(model, "creep", runs, test_runs)  # doctest: +SKIP
    >>> lce.save_model(found.model, "m2.yaml")  # doctest: +SKIP
    """
    chosen = find(effect) if isinstance(effect, str) else effect
    if chosen.reference in model.effects:
        raise LceError(f"the model has {chosen.name} already")
    every = [*runs, *test_runs]
    if why := lacks(chosen, every):
        raise LceError(why)
    known = {chosen.name, *model.effect_names}
    others = [e for e in library().values() if e.name not in known and not lacks(e, every)]
    search = Search(model, runs, test_runs, [chosen, *others], options, watched(progress, cancel))
    step = search.force(chosen)
    trial, after = step.trial, step.with_it.model
    objection = reason(chosen, trial.objection) if trial.objection else ""
    before = _history(model) or [_entry(search.base.model, search, model.fit.get("verdict", ""))]
    history = [*before, _entry(after, search, "not confirmed" if objection else "confirmed")]
    models = columns(search, model)
    estimates = trial.strengths.by_run if trial.strengths else (None,) * len(runs)
    return Addition(
        effect=chosen.name,
        given=model,
        before=search.base.model,
        model=_recorded(after, search, runs, history),
        predicted_reduction=step.predicted_reduction,
        actual_reduction=step.actual_reduction,
        held_out=step.held_out,
        strength_by_run={run.name: e for run, e in zip(runs, estimates, strict=True)},
        amplitude=trial.amplitude,
        objection=objection,
        train=error_table(search, models, search.data.judged),
        test=error_table(search, models, search.tests),
        at_bounds=bounds_reached(search),
    )


def _history(model: Model) -> list[Mapping[str, Any]]:
    """The models tried before, as the file keeps them; none if it says something else under that name."""
    entries = model.fit.get("history")
    if not isinstance(entries, list):
        return []
    return entries if all(isinstance(e, Mapping) and e.keys() >= KEPT for e in entries) else []


def _recorded(model: Model, search: Search, runs: Sequence[Run], history: Sequence[Mapping[str, Any]]) -> Model:
    """The model with standard errors from the data by which its stages were fitted, and the record of the fit."""
    values = {v.key: v for v in model.values}
    record: Mapping[str, Any] = {}
    stages = [p for p in (*search.present.heat[:1], search.present.deformation) if p is not None]
    for stage in stages:
        problem = stage.fit.problem
        result = FitResult.from_problem(problem, runs, problem.starts_k, FitOptions(drive=stage.drive))
        # The part that has the last word on a parameter knows its error.
        known = (result.model.values[i] for i in problem.free)
        values |= {v.key: v for v in known if v.key in values and v.value == values[v.key].value}
        record = result.model.fit
    return model.with_values(tuple(values[v.key] for v in model.values), {**record, "history": list(history)})


def _entry(model: Model, search: Search, verdict: str) -> dict[str, Any]:
    """A row of the history."""
    whole, drive = search.whole(model), search.present.drive
    return {
        "thermal": model.thermal,
        "deformation": model.deformation,
        "effects": list(model.effect_names),
        "train": dict(errors(whole, search.data.judged.runs, drive)),
        "test": dict(errors(whole, search.tests.runs, drive)),
        "verdict": verdict,
    }
