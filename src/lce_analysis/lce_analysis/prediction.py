# SPDX-License-Identifier: Apache-2.0
"""What a model says of a run: the same input, compared sample by sample with what was measured."""

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_smoothing_spline

from lce_data.errors import LceError
from lce_data.noise import noise_floor
from lce_data.run import Run, Series
from lce_model import Model
from lce_model.kernel.compose import RECORDED

Floats = NDArray[np.float64]
Drive = Literal["model", "measured"]
"""What drives the T→d stage: the model's own thermal state, or the measured temperature, smoothed."""

TEMPERATURE: Final = RECORDED.index("temperature")
DISPLACEMENT: Final = RECORDED.index("displacement")
DIRECTION: Final = RECORDED.index("direction")
CAMERA: Final = RECORDED.index("measured_temperature")
DISTANCE: Final = RECORDED.index("measured_displacement")
STRETCHES, MOVED = 8, 5.0
"""Under constant power a series moves where the means of so many stretches differ by so many times its noise."""


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


@dataclass(frozen=True)
class SimulationInput:
    """A run as the kernel takes it.

    time_s, power_w : (n,) the input, each power held until the next time.
    drive_k : (n,) temperature that replaces the thermal stage, or (0,).
    start_k : temperature at the first time, as the first samples show it (NaN where none was measured).
    """

    run: Run
    time_s: Floats
    power_w: Floats
    drive_k: Floats
    deadband_k: float
    start_k: float
    at_temperature: Sampling | None
    at_displacement: Sampling | None

    def simulate(self, model: Model, parameters: Floats, start_k: Floats) -> Floats:
        """Outputs (m, n, len(RECORDED)) for parameter rows (m, k) and start temperatures (m,)."""
        out = np.empty((parameters.shape[0], self.time_s.size, len(RECORDED)))
        model.kernel.run_many(
            self.time_s, self.power_w, self.drive_k, start_k, self.deadband_k, np.ascontiguousarray(parameters), out
        )
        return out


def excited(run: Run) -> bool:
    """Does the laser power of the run change, or do sensors follow a step to it with which the run began?"""
    if run.power is None or np.ptp(run.power.value) > 0.0:
        return True
    series = [s for s in (run.temperature, run.displacement) if s is not None]
    return bool(run.power.value[0] > 0.0) and any(
        np.ptp([part.mean() for part in np.array_split(s.value, STRETCHES)]) > MOVED * noise_floor(s) for s in series
    )


def _at_rest(run: Run) -> Floats:
    """Temperatures before the laser is first on, at most ten; the first one where it is on at once."""
    if run.temperature is None:
        return np.empty(0)
    time, value = run.temperature.time_s, run.temperature.value
    if run.power is None or not np.any(run.power.value > 0.0):
        return value[:10]
    dark = int(np.count_nonzero(time <= run.power.time_s[np.argmax(run.power.value > 0.0)]))
    return value[: min(max(dark, 1), 10)]


def simulation_input(run: Run, model: Model) -> SimulationInput:
    """Lay a run out on the grid of its laser power (of its temperature, where no power was recorded).

    LceError where the run lacks what the model needs, or is of a strip of another length.
    """
    if "strip.length" in model and run.strip_length_m not in (None, model["strip.length"]):
        raise LceError(
            f"{run.name}: its strip is {run.strip_length_m} m long, and the model's {model['strip.length']:g} m; "
            f"fit a model to it with --set strip.length={run.strip_length_m}"
        )
    if run.power is None and model.thermal != "none" and model.deformation == "none":
        raise LceError(f"{run.name}: no laser power was recorded, and the model has only a thermal stage")
    if run.power is None:
        assert run.temperature is not None  # read_run lets no run without input through
        return _laid_out(run, run.temperature.time_s, np.zeros_like(run.temperature.value), smoothed(run.temperature))
    if model.thermal == "none":
        if run.temperature is None:
            raise LceError(f"{run.name}: the model has no thermal stage, and no temperature was measured")
        grid = run.power.time_s
        drive = np.interp(grid, run.temperature.time_s, smoothed(run.temperature))
        return _laid_out(run, grid, run.power.value, drive)
    time, power = run.power.time_s, run.power.value
    last = max(s.time_s[-1] for s in (run.temperature, run.displacement, run.power) if s is not None)
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
        at_temperature=None if run.temperature is None else Sampling.between(time_s, run.temperature.time_s),
        at_displacement=None if run.displacement is None else Sampling.between(time_s, run.displacement.time_s),
    )


def smoothed(series: Series, around: Floats | None = None) -> Floats:
    """The series without its noise, at its own times: a smoothing spline (generalised cross-validation).

    ``around`` is a model of the same series; then only the difference is smoothed, so that the corners that the model
    knows of (the laser switched on or off) stay corners.
    """
    base = np.zeros_like(series.value) if around is None else around
    difference = series.value - base
    if series.value.size < 8:
        return series.value
    return np.asarray(base + make_smoothing_spline(series.time_s, difference)(series.time_s))


def measured_drive(prepared: SimulationInput, model: Model, start_k: float) -> SimulationInput:
    """The same run, driven by its measured temperature smoothed around the model's thermal state."""
    run = prepared.run
    if run.temperature is None or prepared.at_temperature is None:
        raise LceError(f"{run.name}: no temperature was measured that could drive the deformation")
    if prepared.drive_k.size:
        return prepared
    out = prepared.simulate(model, model.vector[None], np.array([start_k]))[0]
    thermal, at_samples = out[:, TEMPERATURE], prepared.at_temperature(out[:, CAMERA])
    correction = smoothed(run.temperature, at_samples) - at_samples
    drive = thermal + np.interp(prepared.time_s, run.temperature.time_s, correction)
    return _laid_out(run, prepared.time_s, prepared.power_w, drive)


def starts_at(prepared: SimulationInput, ambient_k: float) -> bool:
    """Is the strip at rest with its surroundings when the run begins, as far as its first samples can tell?

    Then it is taken to be so exactly: a difference of a hundredth of a kelvin would set it on the cooling branch.
    """
    rest = _at_rest(prepared.run)
    if prepared.run.temperature is None:
        return True
    return abs(prepared.start_k - ambient_k) < 3.0 * noise_floor(prepared.run.temperature) / math.sqrt(rest.size) + 0.02


def start_temperature(prepared: SimulationInput, model: Model) -> float:
    """Temperature [K] at the beginning of a run, by least squares on all that was measured.

    The first camera sample alone (0.06 K rms) would be felt in the displacement, so the start is estimated like a
    parameter of its own. A run that starts at rest, or without temperatures, starts at the ambient temperature.
    """
    if prepared.drive_k.size:
        return float(prepared.drive_k[0])
    if starts_at(prepared, model["ambient.t_env"]):
        return model["ambient.t_env"]
    start = prepared.start_k
    for _ in range(3):
        step = 0.05
        rows = np.repeat(model.vector[None], 2, axis=0)
        out = prepared.simulate(model, rows, np.array([start, start + step]))
        numerator = denominator = 0.0
        for series, sampling, column in _measured(prepared):
            modelled = sampling(out[:, :, column])
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


def _measured(prepared: SimulationInput) -> list[tuple[Series, Sampling, int]]:
    found: list[tuple[Series, Sampling, int]] = []
    if prepared.run.temperature is not None and prepared.at_temperature is not None and not prepared.drive_k.size:
        found.append((prepared.run.temperature, prepared.at_temperature, CAMERA))
    if prepared.run.displacement is not None and prepared.at_displacement is not None:
        found.append((prepared.run.displacement, prepared.at_displacement, DISTANCE))
    return found


@dataclass(frozen=True)
class Prediction:
    """A model's account of a run.

    time_s, temperature_k, displacement_m, direction : (n,) the strip on the grid of the input; NaN where a stage is
    missing.
    temperature_at_samples_k, displacement_at_samples_m : what the sensors show at the times of the measured series,
    None where there is no such series or no such stage.
    """

    time_s: Floats
    temperature_k: Floats
    displacement_m: Floats
    direction: Floats
    temperature_at_samples_k: Floats | None
    displacement_at_samples_m: Floats | None
    start_temperature_k: float


def predict(model: Model, run: Run, drive: Drive = "model") -> Prediction:
    """Simulate the run with the model; LceError where the run lacks what the model needs.

    With ``drive="measured"`` the measured temperature, smoothed, drives the T→d stage, and only the displacement is
    predicted by the model.
    """
    prepared = simulation_input(run, model)
    start = start_temperature(prepared, model)
    out = prepared.simulate(model, model.vector[None], np.array([start]))[0]
    temperature, camera = np.ascontiguousarray(out[:, TEMPERATURE]), out[:, CAMERA]
    if drive == "measured" and model.deformation != "none":
        prepared = measured_drive(prepared, model, start)
        out = prepared.simulate(model, model.vector[None], np.array([start]))[0]
    displacement = np.ascontiguousarray(out[:, DISPLACEMENT])
    thermal = model.thermal != "none" and run.power is not None
    return Prediction(
        time_s=prepared.time_s,
        temperature_k=temperature,
        displacement_m=displacement,
        direction=np.ascontiguousarray(out[:, DIRECTION]),
        temperature_at_samples_k=prepared.at_temperature(camera) if prepared.at_temperature and thermal else None,
        displacement_at_samples_m=(
            prepared.at_displacement(out[:, DISTANCE])
            if prepared.at_displacement and model.deformation != "none"
            else None
        ),
        start_temperature_k=start,
    )
