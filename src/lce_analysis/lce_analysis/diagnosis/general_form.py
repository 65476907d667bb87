# SPDX-License-Identifier: Apache-2.0
"""Has an effect the form of what is missing? A free curve at its place says so.

An effect without memory that depends on one quantity alone is a curve over that quantity at one place of the model.
Thermal radiation is a loss of heat over the temperature, and so is natural convection: each has a form of its own, and
the curve is the form of both. Beside the true effect a free curve explains hardly more; beside one that only looks like
it the curve explains what the effect leaves.
"""

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lce_analysis.covariates import covariates_on_grid
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, error_as_it_stands, refit
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.identification.problem import Problem
from lce_analysis.options import DiagnoseOptions
from lce_analysis.unknown_function import Candidate, directions, ends, with_curve
from lce_data.progress import Progress
from lce_model.closures import PLACES, closure
from lce_model.closures.covariates import COVARIATES, NUMBER
from lce_model.effects import Effect
from lce_model.terms import SIGNALS, inputs_of, reads

Floats = NDArray[np.float64]

PLACE: Final = {closure(p.name).outputs[0]: p.name for p in PLACES} | {"ambient": "heat", "stretch": "strain"}
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
"""What an effect depends on, by the signal that it reads."""
CONSTANT: Final = frozenset({"ambient", "rest_temperature", "loss_rate", "reference_order", "deadband"})
"""Signals that are one number in a run, but for what other effects do to them."""
SHARES: Final = (1.0, 0.3, 0.0)
"""Shares of the linear estimate of the curve at which its refit may begin."""
ROOM: Final = 5.0
"""A knot of the curve may move by so many times the size of the curve that the linear estimate has."""
UNDETERMINED: Final = 1e-6
"""Combinations with singular values below this part of the largest are left out of the linear estimate."""
ITERATIONS: Final = 40


class GeneralForm(NamedTuple):
    """A curve over a quantity at a place, both by their names in :mod:`lce_model.closures`."""

    place: str
    quantity: str


def general_form(effect: Effect) -> GeneralForm | None:
    """The curve of which an effect is a special form; None if it remembers, drifts, or depends on more quantities."""
    return None if drifts(effect) else _curve(effect)


def drifts(effect: Effect) -> bool:
    """Does it change with time alone, from the beginning? Such an effect has no form of its own.

    Whatever changes at its place with time is a drift, be it straight or not.
    """
    form = _curve(effect)
    return form is not None and form.quantity == "time" and not effect.in_durations


def _curve(effect: Effect) -> GeneralForm | None:
    if len(effect.outputs) != 1 or effect.outputs[0] not in PLACE or effect.states or effect.arrays:
        return None
    (changed,) = effect.outputs
    signals = {signal for signal in SIGNALS if signal != changed and reads(effect, signal)} - CONSTANT
    if inputs_of([effect]) or not signals <= QUANTITY.keys():
        return None
    quantities = {QUANTITY[signal] for signal in signals}
    if not quantities and changed in QUANTITY:
        quantities = {QUANTITY[changed]}
    return GeneralForm(PLACE[changed], *quantities) if len(quantities) == 1 else None


def refitted_with_curve(
    stage: StageProblem, form: GeneralForm, options: DiagnoseOptions, progress: Progress
) -> LinearizedFit | None:
    """A part of a fitted model refitted with a free curve in it; None if these runs show no such curve."""
    without, term = stage.fit.problem, closure(form.place)
    if term.reference in without.model.effects:
        return None
    free = [without.model.values[i].key for i in without.free]
    model = without.model.add(term)
    problem = replace(without, model=model, free=tuple(model.index(key) for key in free))
    candidate = _candidate(problem, form)
    if candidate is None:
        return None
    weights = _linear_estimate(problem, candidate, stage.fit)
    room = [ROOM * float(np.max(np.abs(weights)))] * weights.size
    if room[0] == 0.0:
        return None
    starts = [with_curve(problem, candidate, (share * weights).tolist(), room) for share in SHARES]
    label = f"a curve over the {candidate.covariate.words}"
    return refit(min(starts, key=error_as_it_stands), label, progress, min(ITERATIONS, options.iterations))


def _candidate(problem: Problem, form: GeneralForm) -> Candidate | None:
    """The curve between the ends of what its quantity does in the runs; None if it is not known, or constant."""
    observed = sorted({series.run for series in problem.observed})
    runs = [covariates_on_grid(problem.inputs[i], problem.simulated(i)) for i in observed]
    if not all(form.quantity in run for run in runs):
        return None
    between = ends(form.quantity, np.concatenate([run[form.quantity] for run in runs]))
    (place,) = (p for p in PLACES if p.name == form.place)
    return None if between is None else Candidate(place, COVARIATES[NUMBER[form.quantity]], None, *between)


def _linear_estimate(problem: Problem, candidate: Candidate, fit: LinearizedFit) -> Floats:
    """(KNOTS,) the curve that explains most, to first order, beside the free parameters of a fit at its optimum."""
    here = problem.response(problem.model.vector[None])[0]
    columns = np.column_stack([fit.jacobian, directions(problem, candidate, here).T])
    size = np.linalg.norm(columns, axis=0)
    size[size == 0.0] = 1.0
    found, *_ = np.linalg.lstsq(columns / size, -fit.residual, rcond=UNDETERMINED)
    return np.asarray((found / size)[fit.jacobian.shape[1] :])
