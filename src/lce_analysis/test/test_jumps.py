# SPDX-License-Identifier: Apache-2.0
"""A jump of a series is found; a fast motion is none. Samples around a measured jump count in no fit."""

from collections.abc import Callable

import numpy as np

from lce_analysis.identification.problem import observed_series
from lce_analysis.jumps import LEFT_OUT_S, away_from, discontinuities
from lce_analysis.prediction import simulation_input
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run
from lce_model import Model

TIME = np.arange(0.0, 60.0, 0.01)
SLOW = 1e-3 * np.sin(0.3 * TIME)
NOISE = 4e-6


def test_a_jump_is_found_at_the_first_sample_behind_it() -> None:
    jumps = discontinuities(TIME, SLOW + 2e-4 * (TIME >= 20.0) - 3e-4 * (TIME >= 41.5), NOISE)
    np.testing.assert_allclose(jumps, [20.0, 41.5])


def test_a_smooth_series_has_none() -> None:
    assert discontinuities(TIME, SLOW, NOISE).size == 0


def test_a_fast_motion_over_several_samples_is_none() -> None:
    ramp = 2e-4 * np.clip((TIME - 20.0) / 0.05, 0.0, 1.0)
    assert discontinuities(TIME, SLOW + ramp, NOISE).size == 0
    decay = 2e-4 * np.where(TIME < 20.0, 0.0, 1.0 - np.exp(-(TIME - 20.0) / 0.05))
    assert discontinuities(TIME, SLOW + decay, NOISE).size == 0


def test_a_jump_below_the_noise_of_the_sensor_is_none() -> None:
    assert discontinuities(TIME, 1e-6 * (TIME >= 20.0), NOISE).size == 0


def test_samples_near_any_jump_are_left_out_and_no_others() -> None:
    away = away_from(np.array([20.0, 41.5]), TIME)
    distance = np.minimum(np.abs(TIME - 20.0), np.abs(TIME - 41.5))
    np.testing.assert_array_equal(away, distance >= LEFT_OUT_S)
    assert away_from(np.empty(0), TIME).all()


def test_samples_around_a_measured_jump_count_in_no_fit(recorded: Callable[..., Run], strip: Model) -> None:
    run = recorded(extra=lambda time, temperature, displacement: np.where(time > 40.0, 5e-4, 0.0))
    series = run.series[DISPLACEMENT]
    jumps = discontinuities(series.time_s, series.value, NOISE)
    assert jumps[-1] == 40.01
    noise = {TEMPERATURE: 0.06, DISPLACEMENT: NOISE}
    heat, movement = observed_series([simulation_input(run, strip)], noise)
    assert heat.keep is None
    assert movement.keep is not None
    np.testing.assert_array_equal(movement.keep > 0.0, away_from(jumps, series.time_s))
