# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest
from scipy.signal import lsim

from lce_control.filters import LowPass, Sample, Slope

PERIOD_S = 0.02


def polygon(seed: int, size: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of a signal that runs straight from sample to sample, beginning at rest."""
    random = np.random.default_rng(seed)
    return PERIOD_S * np.arange(size), np.concatenate([[0.0], random.normal(size=size - 1)])


def through(block: LowPass, times: np.ndarray, values: np.ndarray) -> list[float]:
    return [block.step(Sample(v, t)).value for t, v in zip(times, values, strict=True)]


def test_the_filter_is_that_of_6_1() -> None:
    times, values = polygon(1)
    _, exact, _ = lsim(([2.0], [0.1, 1.0]), values, times)
    np.testing.assert_allclose(through(LowPass(0.1, gain=2.0), times, values), exact, atol=1e-12)


def test_the_slope_is_the_filtered_derivative_of_6_2() -> None:
    times, values = polygon(2)
    _, exact, _ = lsim(([30.0, 0.0], [1.0, 30.0]), values, times)
    slope = Slope(30.0)
    ours = [slope.step(Sample(v, t)) for t, v in zip(times, values, strict=True)]
    np.testing.assert_allclose(ours, exact, atol=1e-10)


def test_more_samples_of_the_same_straight_lines_change_nothing() -> None:
    random = np.random.default_rng(3)
    times = np.cumsum(random.uniform(0.001, 0.3, 50))
    values = random.normal(size=50)
    finer = np.sort(np.concatenate([times, random.uniform(times[0], times[-1], 200)]))
    coarse = through(LowPass(0.1), times, values)
    fine = dict(zip(finer, through(LowPass(0.1), finer, np.interp(finer, times, values)), strict=True))
    np.testing.assert_allclose([fine[t] for t in times], coarse, atol=1e-10)


def test_the_same_sample_again_changes_nothing_and_an_older_one_begins_anew() -> None:
    low_pass, slope = LowPass(0.1), Slope(100.0)
    for t in (0.0, 0.1):
        filtered, steep = low_pass.step(Sample(t, t)), slope.step(Sample(t, t))
    assert low_pass.step(Sample(0.1, 0.1)) == filtered and slope.step(Sample(0.1, 0.1)) == steep > 0.99
    assert low_pass.step(Sample(5.0, -1.0)) == Sample(5.0, -1.0) and slope.step(Sample(5.0, -1.0)) == 0.0


def test_a_ramp_is_followed_at_the_distance_of_the_time_constant() -> None:
    low_pass = LowPass(0.1)
    times = np.arange(0.0, 5.0, 0.1)
    assert through(low_pass, times, 3.0 * times)[-1] == pytest.approx(3.0 * (times[-1] - 0.1))


def test_no_time_constant_is_no_filter() -> None:
    times, values = polygon(4)
    assert through(LowPass(0.0), times, values) == values.tolist()


@pytest.mark.parametrize("dt_s", [1e-12, 1e6])
def test_extreme_intervals_stay_finite_and_between_the_values(dt_s: float) -> None:
    low_pass = LowPass(0.1)
    low_pass.step(Sample(1.0, 0.0))
    assert 1.0 - 1e-9 <= low_pass.step(Sample(2.0, dt_s)).value <= 2.0
    slope = Slope(100.0)
    slope.step(Sample(1.0, 0.0))
    assert math.isfinite(slope.step(Sample(2.0, dt_s)))
