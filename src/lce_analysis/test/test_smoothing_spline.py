# SPDX-License-Identifier: Apache-2.0
"""The smoothing spline beside SciPy's, and beside what is known of it."""

import numpy as np
import pytest
from scipy.interpolate import make_smoothing_spline

from lce_analysis.smoothing_spline import smoothing_spline


@pytest.mark.parametrize("jitter", [0.0, 0.3])
def test_it_is_the_spline_of_scipy_where_that_finds_the_best_strength(jitter: float) -> None:
    rng = np.random.default_rng(0)
    time = 0.1 * (np.arange(400) + jitter * rng.uniform(-1.0, 1.0, 400))
    value = 320.0 + 20.0 * np.sin(time / 3.0) + 0.1 * rng.standard_normal(400)
    theirs = make_smoothing_spline(time, value)(time)
    assert np.abs(smoothing_spline(time, value) - theirs).max() < 1e-3


def test_noise_about_a_straight_line_becomes_the_line() -> None:
    time = np.arange(2000) * 0.1
    noise = 0.1 * np.random.default_rng(1).standard_normal(2000)
    found = smoothing_spline(time, 300.0 + 0.02 * time + noise)
    assert np.abs(found - np.polyval(np.polyfit(time, 300.0 + 0.02 * time + noise, 1), time)).max() < 0.02


def test_values_without_noise_stay_what_they_are() -> None:
    time = np.arange(200) * 0.05
    value = np.sin(time)
    assert np.abs(smoothing_spline(time, value) - value).max() < 1e-6


def test_the_unit_of_the_values_and_of_time_makes_no_difference() -> None:
    rng = np.random.default_rng(2)
    time = np.arange(300) * 0.1
    value = np.cos(time) + 0.1 * rng.standard_normal(300)
    once = smoothing_spline(time, value)
    np.testing.assert_allclose(smoothing_spline(1e3 * time + 7.0, 1e-6 * value) * 1e6, once, rtol=0.0, atol=1e-5)


def test_too_few_values_come_back_as_they_are() -> None:
    value = np.array([1.0, 5.0, 2.0, 0.0])
    assert smoothing_spline(np.arange(4.0), value) is value
