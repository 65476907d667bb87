# SPDX-License-Identifier: Apache-2.0
"""The noise floor of a series whose noise is known."""

import numpy as np
import pytest

from lce_data.noise import noise_floor
from lce_data.run import Series

TIME = np.arange(0.0, 60.0, 0.01)
SMOOTH = 300.0 + 20.0 * np.sin(TIME / 7.0) + 5.0 * np.exp(-TIME / 3.0)
RNG = np.random.default_rng(3)


@pytest.mark.parametrize("sigma", [0.004, 0.06, 1.0])
def test_white_noise_on_a_smooth_signal(sigma: float) -> None:
    assert noise_floor(Series(TIME, SMOOTH + sigma * RNG.standard_normal(TIME.size))) == pytest.approx(sigma, rel=0.05)


def test_corners_and_outliers_do_not_count() -> None:
    corners = 40.0 * np.abs(np.sin(TIME))
    corners[::500] += 30.0
    assert noise_floor(Series(TIME, corners + 0.06 * RNG.standard_normal(TIME.size))) == pytest.approx(0.06, rel=0.05)


def test_a_rounded_series_has_the_noise_of_its_rounding() -> None:
    step = 0.32
    assert noise_floor(Series(TIME, step * np.round(SMOOTH / step))) == pytest.approx(step / np.sqrt(12.0))


def test_a_series_without_noise_has_a_floor_above_zero() -> None:
    assert 0.0 < noise_floor(Series(TIME, SMOOTH)) < 1e-3
    assert noise_floor(Series(TIME, np.zeros_like(TIME))) > 0.0
    assert noise_floor(Series(TIME[:4], SMOOTH[:4])) > 0.0


def test_correlated_noise_is_underestimated_as_the_docstring_says() -> None:
    kernel = np.ones(20) / np.sqrt(20.0)
    slow = np.convolve(RNG.standard_normal(TIME.size), kernel, "same")
    assert noise_floor(Series(TIME, SMOOTH + slow)) < 0.5
