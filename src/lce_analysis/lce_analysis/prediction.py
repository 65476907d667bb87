# SPDX-License-Identifier: Apache-2.0
"""What a model says of a run: the same input, compared sample by sample with what was measured."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lce_analysis.inputs import acting, check_inputs, without_noise
from lce_analysis.options import Drive, FitOptions
from lce_analysis.smoothing_spline import smoothing_spline
from lce_data.channels import AMBIENT, SENSORS, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_data.noise import noise_floor
from lce_data.run import Run, Series
from lce_model import Model, RunValue
from lce_model.kernel.generate import RECORDED
from lce_model.simulation import NO_DRIVE

Floats = NDArray[np.float64]

STATE: Final[Mapping[str, int]] = {name: RECORDED.index(name) for name in ("temperature", "displacement", "direction")}
"""Columns of the kernel's output that hold the true state of the strip."""
COLUMN: Final[Mapping[Channel, int]] = {
    channel: RECORDED.index(channel.output) for channel in SENSORS if channel.output is not None
}
"""Columns that hold what each sensor shows."""
MECHANICAL: Final = tuple(channel for channel in SENSORS if channel is not TEMPERATURE)
"""Sensors that show what happens behind the temperature."""
AMBIENT_KEY: Final = "ambient.t_env"
INTERVALS: Final = 8
"""Intervals of a run whose means show a drift; a number of the method, not a threshold."""


@dataclass(frozen=True)
class Sampling:
    """Linear interpolation from a grid of times to the times of a sensor."""

    index: NDArray[np.intp]
    weight: Floats

    @classmethod
    def between(cls, grid_s: Floats, sample_s: Floats) -> "Sampling":
        """From times (n,) of a grid to times (k,) of samples; outside the grid its ends hold."""
        index = np.clip(np.searchsorted(grid_s, sample_s, side="right") - 1, 0, grid_s.size - 2)
        weight = np.clip((sample_s - grid_s[index]) / (grid_s[index + 1] - grid_s[index]), 0.0, 1.0)
        return cls(index, weight)

    def __call__(self, values: Floats) -> Floats:
        """``values`` (…, n) on the grid → (…, k) at the samples."""
        return values[..., self.index] * (1.0 - self.weight) + values[..., self.index + 1] * self.weight

    def of_outputs(self, out: Floats, column: int) -> Floats:
        """The same of a column of kernel outputs (m, n, columns) → (m, k), without the interpreter's lock."""
        found = np.empty((out.shape[0], self.index.size))
        _interpolate(out, column, self.index, self.weight, found)
        return found


@njit(nogil=True, cache=True)
def _interpolate(out: Floats, column: int, index: NDArray[np.intp], weight: Floats, found: Floats) -> None:
    for j in range(out.shape[0]):
        for i in range(index.size):
            at = index[i]
            found[j, i] = out[j, at, column] * (1.0 - weight[i]) + out[j, at + 1, column] * weight[i]


@dataclass(frozen=True)
class SimulationInput:
    """A run as the kernel takes it.

    time_s, power_w : (n,) the input, each power held until the next time.
    drive_k : (n,) temperature that replaces the thermal stage, or (0,).
    deadband_k : reversals of ``drive_k`` smaller than this are noise.
    start_k : temperature at the first time, as the first samples show it (NaN if none was measured).
    sampling : from the grid to the samples of each sensor that measured.
    """

    run: Run
    time_s: Floats
    power_w: Floats
    drive_k: Floats
    deadband_k: float
    start_k: float
    sampling: Mapping[Channel, Sampling]

    @property
    def driven(self) -> bool:
        """Does a given temperature replace the thermal stage?"""
        return self.drive_k.size > 0

    @cached_property
    def inputs(self) -> Mapping[Channel, Floats]:
        """The optional inputs of the run on the grid (n,) [SI]: straight between samples, and the ends hold."""
        return {c: np.interp(self.time_s, s.time_s, without_noise(s)) for c, s in self.run.inputs.items()}

    def columns(self, channels: Sequence[Channel]) -> Floats:
        """Optional inputs as the kernel takes them (n, channels); NaN where the run lacks one."""
        unknown = np.full(self.time_s.size, np.nan)
        given = [self.inputs.get(channel, unknown) for channel in channels]
        return np.stack(given, axis=1) if given else np.empty((self.time_s.size, 0))

    def at_rest_k(self, model: Model, parameters: Floats) -> Floats:
        """Temperature (m,) [K] of the surroundings at the first time, for parameter rows (m, k)."""
        kernel = model.kernel
        if AMBIENT not in kernel.inputs:
            return parameters[:, model.index(AMBIENT_KEY)].copy()
        out = np.empty((parameters.shape[0], 1, len(RECORDED)))
        given, starts = self.columns(kernel.inputs)[:1], np.full(parameters.shape[0], np.nan)
        rows = np.ascontiguousarray(parameters)
        kernel.run_many(self.time_s[:1], self.power_w[:1], NO_DRIVE, given, starts, self.deadband_k, rows, out)
        return np.ascontiguousarray(out[:, 0, STATE["temperature"]])

    def simulate(self, model: Model, parameters: Floats, start_k: Floats) -> Floats:
        """Outputs (m, n, len(RECORDED)) for parameter rows (m, k) and start temperatures (m,).

        A start temperature of NaN is that of the surroundings. An optional input that the run lacks is NaN: see
        :func:`lce_analysis.inputs.lacks`.
        """
        out = np.empty((parameters.shape[0], self.time_s.size, len(RECORDED)))
        kernel, rows = model.kernel, np.ascontiguousarray(parameters)
        given = self.columns(kernel.inputs)
        kernel.run_many(self.time_s, self.power_w, self.drive_k, given, start_k, self.deadband_k, rows, out)
        return out


def excited(run: Run, options: FitOptions = FitOptions()) -> bool:
    """Does the laser power of the run change, or do sensors follow a step to it with which the run began?"""
    if run.power is None or np.ptp(run.power.value) > 0.0:
        return True
    series = run.measured.values()
    return bool(run.power.value[0] > 0.0) and any(
        np.ptp([part.mean() for part in np.array_split(s.value, INTERVALS)]) > options.moved * noise_floor(s)
        for s in series
    )


def _at_rest(run: Run) -> Floats:
    """Temperatures before the laser is first on, at most ten; only the first if it is on at once."""
    if run.temperature is None:
        return np.empty(0)
    time, value = run.temperature.time_s, run.temperature.value
    if run.power is None or not np.any(run.power.value > 0.0):
        return value[:10]
    dark = int(np.count_nonzero(time <= run.power.time_s[np.argmax(run.power.value > 0.0)]))
    return value[: min(max(dark, 1), 10)]


def ambient_at_rest(run: Run) -> float | None:
    """Temperature [K] before the laser was first on, or at the first sample if it was on at once.

    It is that of the surroundings if the strip had come to rest. None if power or temperature was not recorded, or if
    the temperature drifted before the laser was on.
    """
    rest = np.empty(0) if run.power is None else _at_rest(run)
    if run.temperature is None or rest.size == 0:
        return None
    first, last = (float(np.mean(part)) for part in np.array_split(rest, 2)) if rest.size > 3 else (rest[0], rest[0])
    drifts = abs(last - first) > 3.0 * noise_floor(run.temperature) * math.sqrt(4.0 / rest.size) + 0.02
    return None if drifts else float(np.mean(rest))


def with_ambient_at_rest(model: Model, runs: Sequence[Run]) -> Model:
    """The model, its ambient temperature in runs that it does not know taken from their samples at rest.

    Only where the ambient temperature varies from run to run.
    """
    variation = model.varies.get(AMBIENT_KEY)
    if variation is None:
        return model
    spec, by_run = model.values[model.index(AMBIENT_KEY)], dict(variation.by_run)
    for run in runs:
        rest = ambient_at_rest(run)
        if rest is not None and not model.knows(AMBIENT_KEY, run.name, run.sha256):
            by_run[run.name] = RunValue(min(max(rest, spec.lower), spec.upper))
    return model.varying({**model.varies, AMBIENT_KEY: replace(variation, by_run=by_run)})


def model_of_run(model: Model, run: Run) -> Model:
    """The model with the values of one run, where parameters vary from run to run.

    A run that the model does not know has the value of all, and the ambient temperature of its samples at rest.
    """
    if not model.varies:
        return model
    return with_ambient_at_rest(model, [run]).of_run(run.name, run.sha256)


def says_nothing(run: Run, model: Model) -> bool:
    """Is there nothing in a run that a model explains? Without a laser power it tells nothing of the heat."""
    return run.power is None and model.deformation == "none"


def simulation_input(run: Run, model: Model) -> SimulationInput:
    """Lay a run out on the grid of its laser power (of its temperature, where no power was recorded).

    Raises LceError if the run lacks what the model needs, or is of a strip of another length.
    """
    check_inputs(run, acting(model))
    if "strip.length" in model and run.strip_length_m not in (None, model["strip.length"]):
        raise LceError(
            f"{run.name}: its strip is {run.strip_length_m} m long, and the model's {model['strip.length']:g} m; "
            f"fit a model to it with --set strip.length={run.strip_length_m}"
        )
    if model.thermal != "none" and says_nothing(run, model):
        raise LceError(f"{run.name}: no laser power was recorded, and the model has only a thermal stage")
    if run.power is None:
        if run.temperature is None:
            raise LceError(f"{run.name}: neither laser power nor temperature was recorded; the model needs an input")
        return _laid_out(run, run.temperature.time_s, np.zeros_like(run.temperature.value), smoothed(run.temperature))
    if model.thermal == "none":
        if run.temperature is None:
            raise LceError(f"{run.name}: the model has no thermal stage, and no temperature was measured")
        grid = run.power.time_s
        drive = np.interp(grid, run.temperature.time_s, smoothed(run.temperature))
        return _laid_out(run, grid, run.power.value, drive)
    time, power = run.power.time_s, run.power.value
    last = max(s.time_s[-1] for s in run.measured.values())
    if last > time[-1]:
        time, power = np.append(time, last), np.append(power, power[-1])
    return _laid_out(run, time, power, np.empty(0))


def _laid_out(run: Run, time_s: Floats, power_w: Floats, drive_k: Floats) -> SimulationInput:
    deadband = noise_floor(run.temperature) if drive_k.size and run.temperature is not None else 0.0
    return SimulationInput(
        run=run,
        time_s=np.ascontiguousarray(time_s),
        power_w=np.ascontiguousarray(power_w),
        drive_k=np.ascontiguousarray(drive_k),
        deadband_k=deadband,
        start_k=float(np.mean(rest)) if (rest := _at_rest(run)).size else float("nan"),
        sampling={channel: Sampling.between(time_s, series.time_s) for channel, series in run.measured.items()},
    )


def smoothed(series: Series, around: Floats | None = None) -> Floats:
    """The series without its noise, at its own times: a smoothing spline (generalised cross-validation).

    ``around`` is a model of the same series; then only the difference is smoothed, so that the corners that the model
    knows of (the laser switched on or off) stay corners.
    """
    base = np.zeros_like(series.value) if around is None else around
    return base + smoothing_spline(series.time_s, series.value - base)


def measured_drive(run_input: SimulationInput, model: Model, start_k: float) -> SimulationInput:
    """The same run, driven by its measured temperature smoothed around the model's thermal state."""
    run = run_input.run
    if run.temperature is None:
        raise LceError(f"{run.name}: no temperature was measured that could drive the deformation")
    if run_input.driven:
        return run_input
    out = run_input.simulate(model, model.vector[None], np.array([start_k]))[0]
    thermal = out[:, STATE["temperature"]]
    at_samples = run_input.sampling[TEMPERATURE](out[:, COLUMN[TEMPERATURE]])
    correction = smoothed(run.temperature, at_samples) - at_samples
    drive = thermal + np.interp(run_input.time_s, run.temperature.time_s, correction)
    return _laid_out(run, run_input.time_s, run_input.power_w, drive)


def starts_at(run_input: SimulationInput, ambient_k: float) -> bool:
    """Is the strip at rest with its surroundings when the run begins, as far as its first samples can tell?

    Then it is taken to be so exactly: a difference of a hundredth of a kelvin would set it on the cooling branch.
    """
    rest = _at_rest(run_input.run)
    if run_input.run.temperature is None:
        return True
    return (
        abs(run_input.start_k - ambient_k) < 3.0 * noise_floor(run_input.run.temperature) / math.sqrt(rest.size) + 0.02
    )


def start_temperature(run_input: SimulationInput, model: Model) -> float:
    """Temperature [K] at the beginning of a run, by least squares on all that was measured.

    The first camera sample alone (0.06 K rms) would be felt in the displacement, so the start is estimated like a
    parameter of its own. A run that starts at rest, or without temperatures, starts at the ambient temperature.
    """
    if run_input.driven:
        return float(run_input.drive_k[0])
    ambient = float(run_input.at_rest_k(model, model.vector[None])[0])
    if starts_at(run_input, ambient):
        return ambient
    start = run_input.start_k
    for _ in range(3):
        step = 0.05
        rows = np.repeat(model.vector[None], 2, axis=0)
        out = run_input.simulate(model, rows, np.array([start, start + step]))
        numerator = denominator = 0.0
        for channel, series in run_input.run.measured.items():
            modelled = run_input.sampling[channel](out[:, :, COLUMN[channel]])
            if not np.isfinite(modelled).all():
                continue
            slope = (modelled[1] - modelled[0]) / step
            residual = series.value - modelled[0]
            variance = max(noise_floor(series) ** 2, float(np.mean(residual**2)))
            numerator += float(slope @ residual) / variance
            denominator += float(slope @ slope) / variance
        if denominator <= 0.0:
            return start
        start += float(np.clip(numerator / denominator, -2.0, 2.0))
    return start


@dataclass(frozen=True)
class Prediction:
    """A model's account of a run.

    time_s, temperature_k, displacement_m, direction : (n,) the strip on the grid of the input; NaN where a stage is
    missing.
    at_samples : what each sensor that the model predicts shows at the times of its measured series [SI].
    """

    time_s: Floats
    temperature_k: Floats
    displacement_m: Floats
    direction: Floats
    at_samples: Mapping[Channel, Floats]
    start_temperature_k: float


def predict(model: Model, run: Run, drive: Drive = "model") -> Prediction:
    """Simulate the run with the model. Raises LceError if the run lacks what the model needs.

    With ``drive="measured"`` the measured temperature, smoothed, drives the T→d stage, and only the displacement is
    predicted by the model.
    """
    model = model_of_run(model, run)
    run_input = simulation_input(run, model)
    start = start_temperature(run_input, model)
    thermal = predict_from(run_input, start, model)
    if drive == "model" or model.deformation == "none":
        return thermal
    driven = predict_from(measured_drive(run_input, model, start), start, model)
    # The measured temperature is compared with the thermal stage, never with itself.
    own = {TEMPERATURE: thermal.at_samples[TEMPERATURE]} if TEMPERATURE in thermal.at_samples else {}
    return replace(driven, temperature_k=thermal.temperature_k, at_samples={**driven.at_samples, **own})


def predict_from(run_input: SimulationInput, start_k: float, model: Model) -> Prediction:
    """Simulate a run that is laid out already, from a given start temperature: what is left to do for each new model.

    Parameters
    ----------
    run_input : the run, from :func:`simulation_input` with a model of the same stages.
    start_k : temperature [K] at the first time, from :func:`start_temperature`.
    model : with any values.

    Returns
    -------
    Prediction
        The strip and what its sensors show.

    Examples
    --------
    >>> run_input = simulation_input(run, model)  # doctest: +SKIP
    >>> start_k = start_temperature(run_input, model)  # doctest: +SKIP
    >>> predict_from(run_input, start_k, model.set({"lumped.tau": 25.0})).at_samples  # doctest: +SKIP
    """
    out = run_input.simulate(model, model.vector[None], np.array([start_k]))[0]
    return Prediction(
        time_s=run_input.time_s,
        temperature_k=np.ascontiguousarray(out[:, STATE["temperature"]]),
        displacement_m=np.ascontiguousarray(out[:, STATE["displacement"]]),
        direction=np.ascontiguousarray(out[:, STATE["direction"]]),
        at_samples={
            channel: sampling(out[:, COLUMN[channel]])
            for channel, sampling in run_input.sampling.items()
            if model.predicts(channel) and not (channel is TEMPERATURE and run_input.run.power is None)
        },
        start_temperature_k=start_k,
    )
