# SPDX-License-Identifier: Apache-2.0
"""What each stage of a model is judged on: the least squares of the heat alone, of the deformation, and of both.

The heat is judged first, on the measured temperature alone. Then the displacement: together with the temperature, all
parameters free, as long as this leaves the temperature as the heat alone explains it. Where the deformation would bend
it, or the temperature is far from explained, the thermal parameters stay as the heat alone has them; where not even the
heat explains the temperature, the measured one, smoothed, drives the deformation.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, linearised, refit
from lce_analysis.diagnosis.misfit import JudgedRuns
from lce_analysis.identification.coarse import coarse
from lce_analysis.identification.discontinuities import (
    JUMPS_AT,
    jumping_with_the_strip,
    squared_error,
    without_discontinuities,
)
from lce_analysis.identification.problem import ObservedSeries, Problem, start_conditions
from lce_analysis.identification.stages import acts_back, acts_on_temperature, thermal_stage
from lce_analysis.options import DiagnoseOptions, Drive
from lce_analysis.prediction import MECHANICAL, SimulationInput, measured_drive, model_of_run
from lce_data.channels import SENSORS, TEMPERATURE, Channel
from lce_data.progress import Progress
from lce_model import Model
from lce_model.effects import Effect

Floats = NDArray[np.float64]
Part = Literal["heat", "deformation", "both"]
"""Which part of the model a problem judges: P → T, T → d, or both together."""
Apart = Literal["", "bent", "fails"]
"""Why the heat was fitted without the displacement, if it was."""

SAME_ERROR: Final = 0.01
"""Squared errors that differ by less than this share may be the same: a refit ends where it hardly gets on."""


@dataclass(frozen=True)
class StageProblem:
    """A part of the model beside the runs, with all candidates for it at their null values.

    part : what is judged.
    fit : at least squares without any candidate.
    candidates : effects that could act in this part.
    drive : what drives the deformation.
    """

    part: Part
    fit: LinearizedFit
    candidates: tuple[Effect, ...]
    drive: Drive

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The sensors by which it is judged."""
        return tuple(dict.fromkeys(series.channel for series in self.fit.problem.observed))

    def explained(self, options: DiagnoseOptions, but: Channel | None = None) -> bool:
        """Is every sensor, but one that does not count, within what counts as explained?"""
        return all(x <= options.explained**2 for channel, x in self.fit.mean_squares.items() if channel is not but)


@dataclass(frozen=True)
class StagedFit:
    """A model refitted stage by stage.

    model : without any candidate.
    heat : judged on the temperature alone, once more with the whole model where a candidate acts back on it.
    deformation : judged on the displacement, or on both; None where none was measured.
    apart : why the heat was fitted alone: the deformation would have bent it, or it fails by itself; "" if it was not.
    """

    model: Model
    heat: tuple[StageProblem, ...]
    deformation: StageProblem | None
    apart: Apart

    @property
    def drive(self) -> Drive:
        """What drives the deformation."""
        return "model" if self.deformation is None else self.deformation.drive

    def stage(self, part: Part) -> StageProblem | None:
        """The problem by which a part of the model is judged; None if it is not."""
        if part == "heat":
            return self.heat[0] if self.heat else None
        return self.deformation

    @property
    def mean_squares(self) -> dict[Channel, float]:
        """Mean squared error of each sensor, by the problem that has the last word on it."""
        problems = [p for p in (*self.heat[:1], self.deformation) if p is not None]
        return {channel: x for p in problems for channel, x in p.fit.mean_squares.items()}

    @property
    def error(self) -> float:
        """Sum of the mean squared errors of all sensors."""
        return sum(self.mean_squares.values())

    @property
    def worst(self) -> float:
        """The largest RMS error of a sensor, in units of its noise."""
        return math.sqrt(max(self.mean_squares.values(), default=0.0))

    @property
    def worst_behind_heat(self) -> float:
        """The same of the sensors that a deformation explains."""
        behind = [x for channel, x in self.mean_squares.items() if channel in MECHANICAL]
        return math.sqrt(max(behind, default=0.0))


@dataclass(frozen=True)
class Data:
    """The runs, laid out for simulation.

    recorded : the inputs with every sample, where ``inputs`` are on a coarser grid.
    drivable : could the measured temperature drive every deformation that was measured?
    """

    judged: JudgedRuns
    inputs: tuple[SimulationInput, ...]
    recorded: tuple[SimulationInput, ...] = ()
    drivable: bool = True

    def coarse(self, step_s: float) -> "Data":
        """The same on a coarser grid, with steps of up to ``step_s`` [s]."""
        return replace(self, inputs=tuple(coarse(one, step_s) for one in self.inputs), recorded=self.inputs)

    def observed(self, channels: Sequence[Channel]) -> tuple[ObservedSeries, ...]:
        """The measured series of some channels, each in units of its noise; without a temperature that drives."""
        return tuple(
            ObservedSeries.of(i, run_input, c, self.judged.noise[i][c])
            for i, run_input in enumerate(self.inputs)
            for c in run_input.run.measured
            if c in channels and not (c is TEMPERATURE and run_input.driven)
        )

    def driven_by_measurement(self, model: Model, starts_k: Floats) -> "Data":
        """The runs, their deformation driven by the measured temperature, smoothed around the model's."""

        def driven(inputs: Sequence[SimulationInput]) -> tuple[SimulationInput, ...]:
            return tuple(
                measured_drive(p, model_of_run(model, p.run), float(starts_k[i])) for i, p in enumerate(inputs)
            )

        return replace(self, inputs=driven(self.inputs), recorded=driven(self.recorded))


def with_candidates(model: Model, candidates: Sequence[Effect]) -> Model:
    """The model with every candidate that it lacks, at its null value.

    All stages but the heat alone use the same one, so that it is compiled once.
    """
    return reduce(Model.add, [e for e in candidates if e.reference not in model.effects], model)


def carried(model: Model, values: Model) -> Model:
    """The model with the values of another one, where they have a parameter in common, those of single runs too."""
    shared = model.set({v.key: v.value for v in values.values if v.key in model and v.value != model[v.key]})
    return shared.varying({**model.varies, **{key: v for key, v in values.varies.items() if key in model}})


def refit_stages(
    model: Model,
    data: Data,
    candidates: Sequence[Effect],
    options: DiagnoseOptions,
    progress: Progress,
    heat_alone: bool = False,
) -> StagedFit:
    """The model at least squares, the heat first, with its candidates at their null values beside it.

    heat_alone : leave what is behind the heat as it is, not judged.
    """
    heat = _heat(model, data, candidates, options, progress)
    starts = _starts(model, data)
    if heat:
        fitted = heat[0].fit.problem
        model, starts = carried(model, fitted.model), fitted.split(fitted.first())[1]
    if heat_alone or not any(c in MECHANICAL and model.predicts(c) for p in data.inputs for c in p.run.measured):
        return StagedFit(model, heat, None, "")
    fails = bool(heat) and _fails(heat[0].fit, options)
    if not fails:
        both = _both(model, data, starts, candidates, options, progress)
        if not heat or not _bends(heat[0].fit, both.fit, options):
            return StagedFit(carried(model, both.fit.problem.model), heat, both, "")
    alone = _deformation(model, data, starts, candidates, heat[0].fit, options, progress)
    return StagedFit(carried(model, alone.fit.problem.model), heat, alone, "fails" if fails else "bent")


def _fails(heat: LinearizedFit, options: DiagnoseOptions) -> bool:
    """Is the temperature far from explained? Then nothing of the heat is fitted once more beside the displacement."""
    return heat.mean_squares[TEMPERATURE] > options.near**2


def _bends(heat: LinearizedFit, both: LinearizedFit, options: DiagnoseOptions) -> bool:
    """Is the temperature explained worse together with the displacement than alone?"""
    alone, together = heat.mean_squares[TEMPERATURE], both.mean_squares.get(TEMPERATURE, 0.0)
    return together > alone + options.bent * max(alone, 1.0)


def _heat(
    model: Model, data: Data, candidates: Sequence[Effect], options: DiagnoseOptions, progress: Progress
) -> tuple[StageProblem, ...]:
    observed = data.observed([TEMPERATURE])
    if model.thermal == "none" or not observed:
        return ()
    own = [c for c in candidates if acts_on_temperature(c)]
    back = [c for c in own if model.deformation != "none" and acts_back(c, model)]
    ahead = [c for c in own if c not in back]
    alone = with_candidates(thermal_stage(model), ahead)
    free = _free(alone, model, heat=True)
    problem = Problem(alone, data.inputs, free, _starts(model, data), observed, *start_conditions(data.inputs, model))
    fit = refit(problem, "temperature", progress, options.iterations)
    stages = [StageProblem("heat", fit, tuple(ahead), "model")]
    if back:
        whole = carried(with_candidates(model, candidates), fit.problem.model)
        again = replace(fit.problem, model=whole, free=_free(whole, model, heat=True))
        stages.append(StageProblem("heat", replace(fit, problem=again), tuple(back), "model"))
    return tuple(stages)


def _both(
    model: Model,
    data: Data,
    starts: Floats,
    candidates: Sequence[Effect],
    options: DiagnoseOptions,
    progress: Progress,
) -> StageProblem:
    whole = with_candidates(model, candidates)
    observed = data.observed([c for c in SENSORS if model.predicts(c)])
    conditions = start_conditions(data.inputs, model)
    problem = Problem(whole, data.inputs, _free(whole, model), starts, observed, *conditions)
    fit = _refit_between_jumps(problem, data, "both stages", options, progress)
    part: Part = "both" if any(s.channel is TEMPERATURE for s in observed) else "deformation"
    return StageProblem(part, fit, tuple(candidates), "model")


def _deformation(
    model: Model,
    data: Data,
    starts: Floats,
    candidates: Sequence[Effect],
    heat: LinearizedFit,
    options: DiagnoseOptions,
    progress: Progress,
) -> StageProblem:
    """T → d alone: driven by the thermal state if that explains the temperature, else by the measured one."""
    explained = heat.mean_squares[TEMPERATURE] <= options.explained**2
    drive: Drive = "model" if explained or not data.drivable else "measured"
    data = data if drive == "model" else data.driven_by_measurement(model, starts)
    own = [c for c in candidates if not acts_on_temperature(c)]
    whole = with_candidates(model, candidates)
    observed = data.observed([c for c in MECHANICAL if model.predicts(c)])
    at_ambient = start_conditions(data.inputs, model)[1]
    problem = Problem(whole, data.inputs, _free(whole, model, heat=False), starts, observed, (), at_ambient)
    fit = _refit_between_jumps(problem, data, "displacement", options, progress)
    return StageProblem("deformation", fit, tuple(own), drive)


def _refit_between_jumps(
    problem: Problem, data: Data, label: str, options: DiagnoseOptions, progress: Progress
) -> LinearizedFit:
    """Least squares of the samples away from the jumps of the model, where its grid resolves it.

    Left out are the samples around the jumps that the model has before the refit. They do not hold these jumps where
    they are. So a refit that only gets its jumps to worse times, for hardly any gain away from them, does not count.
    If the model then jumps a little earlier or later than the strip, T* is read off the jumps of the strip, and
    everything else refitted. That model counts unless its error is clearly larger.
    """
    fit, error = _refit_once(problem, data, label, options, progress)
    moved = jumping_with_the_strip(_at(problem, fit), data.recorded)
    if moved is None:
        return fit
    held = replace(moved, free=tuple(i for i in moved.free if moved.model.values[i].key != JUMPS_AT))
    again, reached = _refit_once(held, data, label, options, progress)
    if reached > (1.0 + SAME_ERROR) * error:
        return fit
    return linearised(without_discontinuities(_at(problem, again), data.recorded))


def _at(problem: Problem, fit: LinearizedFit) -> Problem:
    """The problem where a fit ended."""
    return replace(problem, model=fit.problem.model, starts_k=fit.problem.starts_k)


def _refit_once(
    problem: Problem, data: Data, label: str, options: DiagnoseOptions, progress: Progress
) -> tuple[LinearizedFit, float]:
    """A refit away from the jumps, and its error with the samples around them; the start if that error would rise."""
    begins, error = without_discontinuities(problem, data.recorded), squared_error(problem, data.recorded)
    fit = refit(begins, label, progress, options.iterations)
    reached = squared_error(_at(problem, fit), data.recorded)
    return (linearised(begins), error) if reached > error else (fit, reached)


def _free(whole: Model, model: Model, heat: bool | None = None) -> tuple[int, ...]:
    """Positions in ``whole`` of the free parameters of ``model``: of the heat, of what is behind it, or of both."""
    chosen = {t.name for t in model.terms if heat is None or acts_on_temperature(t) is heat}
    return tuple(whole.index(v.key) for v in model.values if model.searches(v) and v.term in chosen)


def _starts(model: Model, data: Data) -> Floats:
    """Where each run starts; the temperature of its surroundings where none was measured."""
    if model.thermal == "none":
        return np.array([p.start_k for p in data.inputs])
    return np.array(
        [p.start_k if np.isfinite(p.start_k) else p.at_rest_k(model, model.vector[None])[0] for p in data.inputs]
    )
