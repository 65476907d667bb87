# SPDX-License-Identifier: Apache-2.0
"""What a sensor would show if a parameter of the model had another value for a short interval of the run.

Three terms beside those of the model change the light, the heat loss or the ambient temperature between two times.
The kernel runs once for each interval, so the responses hold for every model with a thermal stage and for all of its
effects, to first order in the change.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, spans
from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_analysis.prediction import COLUMN, SimulationInput
from lce_data.channels import DISPLACEMENT, TEMPERATURE, Channel
from lce_model import Model
from lce_model.kernel.compose import kernel_of
from lce_model.kernel.generate import RECORDED
from lce_model.terms import STAGES, Parameter, Term

Floats = NDArray[np.float64]

SHORTEST_S: Final = 0.5
"""Length of an interval [s]; in long runs some times that."""
MOST: Final = 240
"""Intervals of a run, at most."""
SAMPLES: Final = 1500
"""Samples of a series, at most: neighbours are averaged."""
ROWS: Final = 32
"""Simulations at once, which bounds the memory."""


@dataclass(frozen=True)
class WalkingParameter:
    """A parameter that may change without a pattern: its name, its words in a sentence, its unit, a small change."""

    name: str
    words: str
    unit: str
    step_size: float


LIGHT: Final = WalkingParameter("light", "light", "1", 1e-3)
LOSS: Final = WalkingParameter("loss", "heat loss", "1", 1e-3)
AMBIENT: Final = WalkingParameter("ambient", "ambient temperature", "K", 1e-2)
CAMERA_ZERO: Final = WalkingParameter("temperature_zero", "zero of the camera", "K", 1.0)
DISTANCE_ZERO: Final = WalkingParameter("displacement_zero", "zero of the distance sensor", "m", 1.0)
WALKING: Final[Mapping[Channel, tuple[WalkingParameter, ...]]] = {
    TEMPERATURE: (LIGHT, LOSS, AMBIENT, CAMERA_ZERO),
    DISPLACEMENT: (DISTANCE_ZERO,),
}
"""The parameters whose walk a sensor would show. Light and loss are factors; their relative change is reported."""


@register_jitable
def share_between(begin: float, end: float, time: float, dt: float) -> float:
    """Share of the step that ends at ``time`` [s] and took ``dt`` [s] within the interval from begin to end."""
    inside = min(time, end) - max(time - dt, begin)
    return inside / dt if inside > 0.0 and dt > 0.0 else 0.0


def _ambient(ambient: float, elapsed_time: float, dt: float, change: float, begin: float, end: float) -> float:
    return ambient + change * share_between(begin, end, elapsed_time, dt)


def _light(light: float, elapsed_time: float, dt: float, change: float, begin: float, end: float) -> float:
    return light * (1.0 + change * share_between(begin, end, elapsed_time, dt))


def _loss(
    heating: float,
    temperature_midway: float,
    ambient: float,
    loss_rate: float,
    elapsed_time: float,
    dt: float,
    change: float,
    begin: float,
    end: float,
) -> float:
    extra = change * share_between(begin, end, elapsed_time, dt)
    return heating - extra * loss_rate * (temperature_midway - ambient)


def _parameters(unit: str) -> tuple[Parameter, ...]:
    return (
        Parameter("change", unit, 0.0, -1e3, 1e3, "change within the interval", "any"),
        Parameter("begin", "s", 0.0, 0.0, 1e9, "beginning of the interval", "any"),
        Parameter("end", "s", 0.0, 0.0, 1e9, "its end", "any"),
    )


_TERMS: Final = {
    AMBIENT: Term("walk_ambient", "surroundings", "T_env + c", _parameters("K"), ("ambient",), _ambient),
    LIGHT: Term("walk_light", "light", "(1 + c) P", _parameters("1"), ("light",), _light),
    LOSS: Term("walk_loss", "heat", "dT/dt = ... - c (T - T_env)/tau", _parameters("1"), ("heating",), _loss),
}


@dataclass(frozen=True)
class WalkRun:
    """One series of one run as a linear problem: residual = slopes · shift + responses · levels + noise.

    name : of the run.
    time_s : (m,) of the samples, [s] since the beginning; neighbours may have been averaged.
    edges_s : (k + 1,) of the intervals.
    residual : (m,) measured minus model in units of the sensor's noise.
    slopes : (m, free) of the fit's free variables.
    responses : by parameter, (m, k) for a change by one unit in each interval.
    """

    name: str
    time_s: Floats
    edges_s: Floats
    residual: Floats
    slopes: Floats
    responses: Mapping[WalkingParameter, Floats]

    @property
    def middles_s(self) -> Floats:
        """(k,) middles of the intervals."""
        return 0.5 * (self.edges_s[1:] + self.edges_s[:-1])


def walk_runs(fit: LinearizedFit, channel: Channel, model: Model) -> list[WalkRun]:
    """Every run that measured the channel, with the responses of all parameters whose walk it would show.

    Parameters
    ----------
    fit : at least squares.
    channel : TEMPERATURE or DISPLACEMENT.
    model : whose thermal stage responds; it may lack the candidates of the fit.
    """
    found = []
    for (begin, end), series in zip(spans(fit.problem.observed), fit.problem.observed, strict=True):
        if series.channel is channel:
            rows = np.vstack([-fit.residual[begin:end], fit.jacobian[begin:end].T])
            found.append(_walk_run(fit.problem, series, rows, model))
    acting = {p for run in found for p, response in run.responses.items() if np.any(response)}
    return [replace(run, responses={p: r for p, r in run.responses.items() if p in acting}) for run in found]


def _walk_run(problem: Problem, series: ObservedSeries, rows: Floats, model: Model) -> WalkRun:
    run_input = problem.inputs[series.run]
    time = run_input.run.series[series.channel].time_s - run_input.time_s[0]
    duration = float(run_input.time_s[-1] - run_input.time_s[0])
    width = SHORTEST_S * max(1.0, math.ceil(duration / SHORTEST_S / MOST))
    count = max(1, math.ceil(duration / width - 1e-9))
    edges = np.asarray(width * np.arange(count + 1), dtype=np.float64)
    own = model.of_run(run_input.run.name, run_input.run.sha256)
    start_k = float(problem.split(problem.first())[1][series.run])
    block = -(-time.size // SAMPLES)
    zero = next(p for p in WALKING[series.channel] if p not in _TERMS)
    inside = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, count - 1)
    responses = {zero: series.weighted((np.arange(count)[:, None] == inside[None]).astype(np.float64))}
    for parameter in (p for p in WALKING[series.channel] if p in _TERMS):
        out = _thermal_responses(run_input, own, parameter, edges, start_k)
        responses[parameter] = series.weighted(series.sampling(out))
    return WalkRun(
        run_input.run.name,
        _averaged(time, block),
        edges,
        _averaged(rows[0], block),
        _averaged(rows[1:], block).T,
        {p: _averaged(r, block).T for p, r in responses.items()},
    )


def _averaged(values: Floats, block: int) -> Floats:
    """Values (…, n) → (…, n // block), means of neighbours."""
    size = values.shape[-1] // block * block
    return np.asarray(values[..., :size].reshape(*values.shape[:-1], -1, block).mean(axis=-1))


def _with_walks(model: Model) -> tuple[Term, ...]:
    """The terms of the model and the three that change it for an interval; a loss stands before the heat balance."""
    ordered: list[Term] = []
    for stage in STAGES:
        own = [t for t in model.terms if t.stage == stage]
        added = [t for t in _TERMS.values() if t.stage == stage]
        place = next((i for i, t in enumerate(own) if "temperature" in t.outputs), len(own))
        ordered += [*own[:place], *added, *own[place:]]
    return tuple(ordered)


def _thermal_responses(
    run_input: SimulationInput, model: Model, parameter: WalkingParameter, edges_s: Floats, start_k: float
) -> Floats:
    """(k, n) change of what the camera shows on the grid, for a change of the parameter by one in each interval."""
    members = _with_walks(model)
    keys = [f"{t.name}.{p.name}" for t in members for p in t.parameters]
    own = {value.key: value.value for value in model.values}
    row = np.array([own.get(key, 0.0) for key in keys])
    rows = np.tile(row, (edges_s.size, 1))
    first = keys.index(f"{_TERMS[parameter].name}.change")
    rows[1:, first] = parameter.step_size
    rows[1:, first + 1], rows[1:, first + 2] = edges_s[:-1], edges_s[1:]
    shown = [_shown(run_input, members, part, start_k) for part in np.array_split(rows, -(-rows.shape[0] // ROWS))]
    out = np.concatenate(shown)
    return np.asarray((out[1:] - out[0]) / parameter.step_size)


def _shown(run_input: SimulationInput, members: Sequence[Term], rows: Floats, start_k: float) -> Floats:
    kernel = kernel_of(tuple(members))
    out = np.empty((rows.shape[0], run_input.time_s.size, len(RECORDED)))
    given, starts = run_input.columns(kernel.inputs), np.full(rows.shape[0], start_k)
    kernel.run_many(
        run_input.time_s, run_input.power_w, run_input.drive_k, given, starts, run_input.deadband_k, rows, out
    )
    return out[:, :, COLUMN[TEMPERATURE]]
