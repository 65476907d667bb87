# SPDX-License-Identifier: Apache-2.0
"""Where a search begins, and on which grid: the fit itself uses every sample."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.problem import Problem
from lce_analysis.prediction import STATE, Sampling, SimulationInput
from lce_data.channels import TEMPERATURE
from lce_data.run import Series
from lce_model import Model
from lce_model.thermal.hammerstein_wiener import PIECES

Floats = NDArray[np.float64]

STEP_K: Final = 0.5
STEP_S: Final = 2.0
"""Grid of the searches: a sample wherever the temperature (K) or the time (s) has moved on so much."""


def with_thermal_guess(model: Model, inputs: Sequence[SimulationInput], tau: float) -> Model:
    """Gain and ambient temperature by linear least squares for a time constant: T is linear in both."""
    spec = {v.key: v for v in model.values}
    tau = float(np.clip(tau, spec["lumped.tau"].lower, spec["lumped.tau"].upper))
    if spec["lumped.tau"].fixed:
        tau = model["lumped.tau"]
    # Not by model.set(): the gain may be held to a range without 1.
    unit, ambient = model.vector, model["ambient.t_env"]
    unit[[model.index("lumped.tau"), model.index("lumped.gain")]] = tau, 1.0
    columns, targets = [], []
    for run_input in inputs:
        if run_input.run.temperature is None:
            continue
        rise = run_input.simulate(model, unit[None], np.array([ambient]))[0, :, STATE["temperature"]] - ambient
        columns.append(run_input.sampling[TEMPERATURE](rise))
        targets.append(run_input.run.temperature.value)
    rise, target = np.concatenate(columns), np.concatenate(targets)
    (gain, ambient), *_ = np.linalg.lstsq(np.column_stack([rise, np.ones_like(rise)]), target)
    guess = {"lumped.tau": tau, "lumped.gain": gain, "ambient.t_env": ambient}
    return model.set(
        {k: float(np.clip(x, spec[k].lower, spec[k].upper)) for k, x in guess.items() if not spec[k].fixed}
    )


def with_curves_guess(model: Model, lumped: Model, inputs: Sequence[SimulationInput]) -> Model:
    """A Hammerstein–Wiener model that is the lumped one: straight curves, one pole, the fast ones and the zero aside.

    The break points are laid over the powers that the runs have.
    """
    top = max(float(run_input.power_w.max()) for run_input in inputs)
    tau, gain = lumped["lumped.tau"], lumped["lumped.gain"]
    guess = {"tau_1": tau, "tau_2": 0.05 * tau, "tau_3": 0.01 * tau, "tau_z": 0.04 * tau, "p_max": top, "w_max": top}
    # A hundredth of a second, as printed, unless the power is known far more coarsely.
    guess["sample_time"] = max(0.01, 0.1 * min(float(np.median(np.diff(i.time_s))) for i in inputs))
    for i in range(1, PIECES + 1):
        guess |= {f"phi_{i}": 1.0, f"psi_{i}": gain}
    changes = {f"hammerstein_wiener.{name}": x for name, x in guess.items()}
    if not model.values[model.index("ambient.t_env")].fixed:
        changes["ambient.t_env"] = lumped["ambient.t_env"]
    spec = {v.key: v for v in model.values}
    return model.set({k: float(np.clip(x, spec[k].lower, spec[k].upper)) for k, x in changes.items()})


def thinned(run_input: SimulationInput) -> SimulationInput:
    """The run on the grid of the searches: a sample wherever the temperature or the time has moved on enough.

    The turning points stay, so that the path is the same.
    """
    temperature, time = run_input.drive_k, run_input.time_s
    turns = 1 + np.flatnonzero(np.diff(np.sign(np.diff(temperature))) != 0.0)
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(temperature)) / STEP_K + np.diff(time) / STEP_S)])
    keep = np.unique(np.concatenate([np.searchsorted(travelled, np.arange(travelled[-1])), turns, [time.size - 1]]))
    if keep.size > time.size // 2:  # too noisy or too short to gain anything
        keep = np.arange(time.size)
    grid = np.ascontiguousarray(time[keep])
    run = run_input.run.with_series(TEMPERATURE, None)
    for channel, series in run.measured.items():
        nearest = np.unique(np.clip(np.searchsorted(series.time_s, grid), 0, series.time_s.size - 1))
        run = run.with_series(channel, Series(series.time_s[nearest], series.value[nearest]))
    return replace(
        run_input,
        run=run,
        time_s=grid,
        power_w=np.ascontiguousarray(run_input.power_w[keep]),
        drive_k=np.ascontiguousarray(temperature[keep]),
        sampling={channel: Sampling.between(grid, series.time_s) for channel, series in run.measured.items()},
    )


def search_box(problem: Problem, inputs: Sequence[SimulationInput]) -> tuple[Floats, Floats]:
    """Where to look for a first guess, in the unit box: the usual ranges, temperatures near those that the strip had.

    What has no usual range is looked for within its bounds.
    """
    coldest = min(float(i.drive_k.min()) for i in inputs)
    hottest = max(float(i.drive_k.max()) for i in inputs)
    values = [problem.model.values[i] for i in problem.free]
    # Differences of temperature are in K too, but start near zero.
    temperature = np.array([v.unit == "K" and v.parameter.lower > 100.0 for v in values])
    lower, upper = problem.transformation.lower, problem.transformation.upper
    usual = np.array([v.parameter.usual or (v.lower, v.upper) for v in values]).T
    low = np.where(temperature, np.maximum(lower, coldest - 40.0), np.maximum(lower, usual[0]))
    high = np.where(temperature, np.minimum(upper, hottest), np.minimum(upper, usual[1]))
    low, high = np.where(low < high, low, lower), np.where(low < high, high, upper)
    return problem.transformation.to_box(low), problem.transformation.to_box(high)
