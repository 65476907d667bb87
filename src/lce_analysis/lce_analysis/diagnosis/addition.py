# SPDX-License-Identifier: Apache-2.0
"""One effect added to a model: refitted with it, the error before and after."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lce_analysis.diagnosis.diagnosis import errors
from lce_analysis.diagnosis.search import Search
from lce_analysis.identification.result import FitResult
from lce_analysis.options import DiagnoseOptions
from lce_data.errors import LceError
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import find, library


@dataclass(frozen=True)
class Addition:
    """A model refitted to the same runs without and with one more effect.

    Attributes
    ----------
    effect : name of the effect.
    before : refitted without it.
    model : with the effect, standard errors, and the record of the fit; ``model.fit["history"]`` is a table of the
    models tried, one mapping each, the oldest first.
    predicted_reduction, actual_reduction : of the squared error in units of the noise, as fractions.
    confirmed : do penalised likelihood and leave-one-run-out both want the effect?
    """

    effect: str
    before: Model
    model: Model
    predicted_reduction: float
    actual_reduction: float
    confirmed: bool

    @property
    def sentence(self) -> str:
        """What adding it did."""
        found = ", on runs left out too" if self.confirmed else "; chance gives as much, or it fails on runs left out"
        return (
            f"With {self.effect} the squared error falls by {self.actual_reduction:.1%} "
            f"({self.predicted_reduction:.1%} was predicted){found}."
        )


def add_effect(
    model: Model,
    effect: str,
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
    effect : a name of the library, or the path of an effect file.
    runs : what the model is fitted to.
    test_runs : held out; only the errors before and after are computed on them.
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
    chosen = find(effect)
    if chosen.reference in model.effects:
        raise LceError(f"the model has {chosen.name} already")
    others = [e for e in library().values() if e.name != chosen.name and e.reference not in model.effects]
    search = Search(model, runs, [chosen, *others], options, watched(progress, cancel))
    confirmed = search.force(chosen)
    (step,) = search.steps
    result = FitResult.from_problem(search.problem, runs, search.problem.starts_k)
    unused = {e.name for e in others}
    after = search.model().with_values(tuple(v for v in result.model.values if v.term not in unused), {})
    before_entry = _entry(search.before, runs, test_runs, model.fit.get("verdict", ""))
    history = [*model.fit.get("history", [before_entry])]
    verdict = "confirmed" if confirmed else "not confirmed"
    history.append(_entry(after, runs, test_runs, verdict))
    record = {**result.model.fit, "history": history}
    return Addition(
        effect=chosen.name,
        before=search.before,
        model=after.with_values(after.values, record),
        predicted_reduction=step.predicted_reduction,
        actual_reduction=step.actual_reduction,
        confirmed=confirmed,
    )


def _entry(model: Model, runs: Sequence[Run], test_runs: Sequence[Run], verdict: str) -> dict[str, Any]:
    """A row of the history."""
    return {
        "thermal": model.thermal,
        "deformation": model.deformation,
        "effects": list(model.effect_names),
        "train": dict(errors(model, runs)),
        "test": dict(errors(model, test_runs)),
        "verdict": verdict,
    }
