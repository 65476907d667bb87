# SPDX-License-Identifier: Apache-2.0
"""Has an effect the form of what is missing? A free curve in its place says so.

An effect without memory that depends on one quantity alone is a curve over that quantity at one place of the model.
Thermal radiation is a loss of heat over the temperature, and so is natural convection: each has a form of its own, and
the curve is the form of both. Beside the true effect a free curve explains hardly more; beside one that only looks like
it the curve explains what the effect leaves.

The curve is also a way out of a poor minimum. It takes the error away first, and the other parameters go where they
belong; from there the effect is refitted without it.
"""

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lce_analysis.covariates import covariates_on_grid
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, refit
from lce_analysis.diagnosis.stage_problem import Part, StagedFit, StageProblem, carried
from lce_analysis.identification.problem import Problem
from lce_analysis.options import DiagnoseOptions
from lce_data.progress import Progress
from lce_model import Model
from lce_model.closures import closure
from lce_model.closures.covariates import NUMBER
from lce_model.closures.forms import KNOTS
from lce_model.effects import Effect
from lce_model.terms import reads

Floats = NDArray[np.float64]

PLACE: Final = {
    "ambient": "heat",
    "heating": "heat",
    "light": "light",
    "order_temperature": "order",
    "stretch": "strain",
    "displacement": "strain",
    "measured_temperature": "temperature_sensor",
    "measured_displacement": "displacement_sensor",
}
"""Where an effect acts, by the signal that it changes."""
QUANTITY: Final = {
    "elapsed_time": "time",
    "power": "power",
    "light": "power",
    "temperature": "temperature",
    "temperature_before": "temperature",
    "temperature_midway": "temperature",
    "measured_temperature": "temperature",
    "warming": "rate",
    "order": "order",
    "displacement": "displacement",
    "measured_displacement": "displacement",
}
"""What an effect depends on, by the signal that it reads; other signals are constant, or no curve is over them."""
TAILS: Final = 0.002
"""Share of the samples on either side that lie beyond the ends of the curve."""
ROOM: Final = 5.0
"""A knot of the curve may move by so many times the size of the curve that the linear estimate has."""
ITERATIONS: Final = 40


class GeneralForm(NamedTuple):
    """A curve over a quantity at a place, both by their names in :mod:`lce_model.closures`."""

    place: str
    quantity: str


def general_form(effect: Effect) -> GeneralForm | None:
    """The curve of which an effect is a special form; None if it remembers, or depends on more than one quantity."""
    changed, *others = effect.outputs
    if others or effect.states or effect.arrays or changed not in PLACE:
        return None
    read = {quantity for signal, quantity in QUANTITY.items() if signal != changed and reads(effect, signal)}
    if not read and changed in QUANTITY:
        read = {QUANTITY[changed]}
    return GeneralForm(PLACE[changed], *read) if len(read) == 1 else None


def unexplained(stage: StageProblem, options: DiagnoseOptions) -> bool:
    """Does the fit of a part of the model leave a sensor beyond what counts as explained?"""
    return max(stage.fit.mean_squares.values()) > options.explained**2


def with_curve(
    fit: StagedFit, part: Part, form: GeneralForm, options: DiagnoseOptions, progress: Progress
) -> LinearizedFit | None:
    """A part of a fitted model refitted with a free curve in it; None if that cannot be simulated beside these runs."""
    stage = fit.stage(part)
    if stage is None:
        return None
    problem = _with_term(stage.fit.problem, fit.model.add(closure(form.place)))
    quantity = _values(problem, form.quantity)
    if quantity is None:
        return None
    keys = [f"closure_{form.place}.w_{k + 1}" for k in range(KNOTS)]
    lower, upper = (float(x) for x in np.quantile(quantity, [TAILS, 1.0 - TAILS]))
    settings = {"strength": 1.0, "covariate": NUMBER[form.quantity], "lower": lower, "upper": upper}
    model = problem.model.set({f"closure_{form.place}.{name}": x for name, x in settings.items()})
    weights = _linear(replace(problem, model=model), stage.fit, keys)
    room = ROOM * float(np.max(np.abs(weights)))
    if not (upper > lower and room > 0.0):
        return None
    start = model.set(dict(zip(keys, weights.tolist(), strict=True)))
    start = start.hold({key: (w - room, w + room) for key, w in zip(keys, weights.tolist(), strict=True)})
    free = tuple(sorted({*problem.free, *(start.index(key) for key in keys)}))
    return refit(replace(problem, model=start, free=free), form.quantity, progress, min(ITERATIONS, options.iterations))


def _with_term(problem: Problem, model: Model) -> Problem:
    """The problem of a larger model, its free parameters the same."""
    free = (problem.model.values[i].key for i in problem.free)
    return replace(problem, model=carried(model, problem.model), free=tuple(model.index(key) for key in free))


def _values(problem: Problem, quantity: str) -> Floats | None:
    """The values that a quantity takes in all runs; None if the model or a run does not know it."""
    runs = [covariates_on_grid(p, problem.simulated(i)) for i, p in enumerate(problem.inputs)]
    return np.concatenate([run[quantity] for run in runs]) if all(quantity in run for run in runs) else None


def _linear(problem: Problem, fit: LinearizedFit, keys: list[str]) -> Floats:
    """(KNOTS,) the curve that explains most, to first order, beside the free parameters of a fit at its optimum."""
    model = problem.model
    step = model.values[model.index(keys[0])].parameter.knee
    rows = [model.vector, *(model.set({key: step}).vector for key in keys)]
    response = problem.response(np.array(rows))
    slopes = (response[1:] - response[0]) / step
    columns = np.column_stack([fit.jacobian, np.where(np.isfinite(slopes), slopes, 0.0).T])
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    found, *_ = np.linalg.lstsq(columns / size, -fit.residual, rcond=1e-6)
    return np.asarray((found / size)[-len(keys) :])
