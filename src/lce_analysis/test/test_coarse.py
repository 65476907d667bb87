# SPDX-License-Identifier: Apache-2.0
"""A coarser grid for searching: the same light, and a simulation that differs by less than the sensors can tell."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.identification.coarse import STEP_S, coarse
from lce_analysis.identification.discontinuities import (
    jumping_with_the_strip,
    squared_error,
    without_discontinuities,
)
from lce_analysis.identification.problem import Problem, observed_series
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.prediction import COLUMN, SimulationInput, simulation_input
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

Floats = NDArray[np.float64]
NOISE = {TEMPERATURE: 0.06, DISPLACEMENT: 4e-6}


def _levels(time: Floats) -> Floats:
    """Power [W] that jumps at times that are on no grid of 0.1 s."""
    return np.select([time < 1.03, time < 13.01, time < 20.02, time < 33.04], [0.0, 1.4, 0.3, 1.1], 0.0)


def _wave(time: Floats) -> Floats:
    return 0.7 - 0.7 * np.cos(0.4 * time)


def _energy(run_input: SimulationInput) -> float:
    return float(run_input.power_w[:-1] @ np.diff(run_input.time_s))


@pytest.mark.parametrize("power", [_levels, _wave])
def test_the_energy_of_the_light_is_kept(
    strip: Model, recorded: Callable[..., Run], power: Callable[[Floats], Floats]
) -> None:
    fine = simulation_input(recorded(power=power, duration_s=45.0), strip)
    found = coarse(fine)
    assert found.time_s.size < 0.3 * fine.time_s.size
    assert np.diff(found.time_s).max() < STEP_S + 1e-9
    assert (found.time_s[0], found.time_s[-1]) == (fine.time_s[0], fine.time_s[-1])
    assert _energy(found) == pytest.approx(_energy(fine), rel=1e-12)


def test_the_light_jumps_where_it_did(strip: Model, recorded: Callable[..., Run]) -> None:
    found = coarse(simulation_input(recorded(power=_levels, duration_s=45.0), strip))
    jumps = found.time_s[1:][np.abs(np.diff(found.power_w)) > 0.02]
    assert jumps == pytest.approx([1.03, 13.01, 20.02, 33.04], abs=0.0101)
    assert set(found.power_w.round(9)) == {0.0, 1.4, 0.3, 1.1}


@pytest.mark.parametrize("power", [_levels, _wave])
def test_the_simulation_differs_by_less_than_a_tenth_of_the_noise(
    strip: Model, recorded: Callable[..., Run], power: Callable[[Floats], Floats]
) -> None:
    fine = simulation_input(recorded(power=power, duration_s=45.0), strip)
    found = coarse(fine)
    start = np.array([strip["ambient.t_env"]])
    outputs = {id(p): p.simulate(strip, strip.vector[None], start)[0] for p in (fine, found)}
    for channel, noise in NOISE.items():
        series = found.run.series[channel]
        assert np.diff(series.time_s).min() > STEP_S - 1e-9
        shown = found.sampling[channel](outputs[id(found)][:, COLUMN[channel]])
        modelled = outputs[id(fine)][:, COLUMN[channel]]
        # Where the temperature turns inside the loop the model jumps, on the coarse grid up to a step sooner or later.
        away = away_from(discontinuities(fine.time_s, modelled, noise), series.time_s)
        assert away.mean() > 0.9
        error = (shown - np.interp(series.time_s, fine.time_s, modelled))[away]
        assert np.sqrt(np.mean(error**2)) < 0.1 * noise


def test_the_samples_that_stay_are_those_that_were_measured(strip: Model, recorded: Callable[..., Run]) -> None:
    run = recorded(duration_s=45.0)
    found = coarse(simulation_input(run, strip)).run
    for channel, series in found.measured.items():
        where = np.searchsorted(run.series[channel].time_s, series.time_s)
        np.testing.assert_array_equal(run.series[channel].value[where], series.value)


def test_a_run_that_is_coarse_already_stays_as_it_is(strip: Model, recorded: Callable[..., Run]) -> None:
    run = recorded(duration_s=45.0)
    run = Run.of("coarse", *(Series(s.time_s[::10], s.value[::10]) for s in run.series.values()), sha256="0" * 64)
    run_input = simulation_input(run, strip)
    assert coarse(run_input) is run_input


def test_samples_of_a_motion_that_the_grid_does_not_resolve_are_left_out() -> None:
    strip, time = default_model("lumped", "dynamic"), np.arange(0.0, 45.0, 0.01)
    displacement = simulate(strip, time, _wave(time)).displacement_m
    displacement += NOISE[DISPLACEMENT] * np.random.default_rng(0).standard_normal(time.size)
    fine = simulation_input(Run.of("wave", Series(time, _wave(time)), displacement=Series(time, displacement)), strip)
    found = coarse(fine)
    problem = Problem(strip, [found], (), np.array([strip["ambient.t_env"]]), observed_series([found], NOISE))
    searched = without_discontinuities(problem, [fine])
    kept = searched.observed[0].counted
    assert kept > 0.9 * problem.size
    before, after = (float(np.sum(p.residuals(p.first()) ** 2)) for p in (problem, searched))
    assert before / problem.size > 10.0
    assert after / kept == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / kept))


def test_a_jump_at_the_wrong_time_counts_for_as_much_as_it_lasts() -> None:
    """Samples away from the jumps, measured and modelled, do not show that the model jumps too early."""
    strip, time = default_model("lumped", "dynamic").set({"dynamic.spinodal": 1e4}), np.arange(0.0, 45.0, 0.01)
    modelled = simulate(strip, time, _wave(time)).displacement_m
    jump = discontinuities(time, modelled, NOISE[DISPLACEMENT])[0]
    noise = NOISE[DISPLACEMENT] * np.random.default_rng(0).standard_normal(time.size)

    def errors(late_s: float) -> tuple[float, float]:
        """Mean squared error away from the jumps, and the squared error that counts those around them."""
        before = int(np.searchsorted(time, jump)) - 1
        waits = (time >= jump) & (time < jump + late_s)
        measured = np.where(waits, modelled[before], modelled) + noise
        run = Run.of("wave", Series(time, _wave(time)), displacement=Series(time, measured))
        whole = simulation_input(run, strip)
        problem = Problem(strip, [whole], (), np.array([strip["ambient.t_env"]]), observed_series([whole], NOISE))
        away = without_discontinuities(problem)
        return float(np.mean(away.residuals(away.first()) ** 2)), squared_error(problem)

    (at_once, least), (late, most) = errors(0.0), errors(0.4)
    assert late == pytest.approx(at_once, abs=0.02)
    # For 0.4 s, 40 samples are off by 3 times the noise instead of once.
    assert most - least == pytest.approx(40 * (3.0**2 - 1.0), rel=0.1)


@pytest.mark.parametrize("off_k", [0.4, -0.4])
def test_t_star_is_read_off_the_jumps_of_the_strip(off_k: float) -> None:
    """Turns, at which both jump at the same time, say nothing of it."""
    problem = _jumping(off_k)
    found = jumping_with_the_strip(problem)
    assert found is not None
    assert found.model["dynamic.t_star"] == pytest.approx(problem.model["dynamic.t_star"] - off_k, abs=0.02)
    assert jumping_with_the_strip(found) is None


def test_where_model_and_strip_jump_together_t_star_is_left_to_the_fit() -> None:
    assert jumping_with_the_strip(_jumping(0.0)) is None


def test_a_t_star_that_is_fixed_is_not_read_off_the_jumps() -> None:
    assert jumping_with_the_strip(replace(_jumping(0.4), free=())) is None


def _jumping(off_k: float) -> Problem:
    """A strip that jumps, and a model of it whose T* is off by so much."""
    time = np.arange(0.0, 120.0, 0.01)
    model = default_model("lumped", "dynamic").set({"dynamic.spinodal": 1e4})
    measured = simulate(model, time, _levels(time)).displacement_m
    measured += NOISE[DISPLACEMENT] * np.random.default_rng(0).standard_normal(time.size)
    wrong = model.set({"dynamic.t_star": model["dynamic.t_star"] + off_k})
    whole = simulation_input(Run.of("levels", Series(time, _levels(time)), displacement=Series(time, measured)), wrong)
    starts_k = np.array([wrong["ambient.t_env"]])
    return Problem(wrong, [whole], (wrong.index("dynamic.t_star"),), starts_k, observed_series([whole], NOISE))
