# SPDX-License-Identifier: Apache-2.0
"""The noise floor of a series whose noise is known."""

import numpy as np
import pytest
from scipy.signal import lfilter

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
    assert noise_floor(Series(TIME, corners + 0.06 * RNG.standard_normal(TIME.size))) == pytest.approx(0.06, rel=0.4)


def test_a_rounded_series_has_the_noise_of_its_rounding() -> None:
    step = 0.32
    assert noise_floor(Series(TIME, step * np.round(SMOOTH / step))) == pytest.approx(step / np.sqrt(12.0))


def test_a_series_without_noise_has_a_floor_above_zero() -> None:
    assert 0.0 < noise_floor(Series(TIME, SMOOTH)) < 1e-3
    assert noise_floor(Series(TIME, np.zeros_like(TIME))) > 0.0
    assert noise_floor(Series(TIME[:4], SMOOTH[:4])) > 0.0


@pytest.mark.parametrize(("memory", "least"), [(0.0, 0.95), (0.6, 0.9), (0.8, 0.9), (0.9, 0.7)])
def test_autoregressive_noise_counts_in_full_as_long_as_its_memory_is_short(memory: float, least: float) -> None:
    kicks = np.sqrt(1.0 - memory**2) * np.random.default_rng(5).standard_normal(TIME.size)
    noise = lfilter([1.0], [1.0, -memory], kicks)
    assert least < noise_floor(Series(TIME, SMOOTH + noise)) < 1.08


def test_noise_slower_than_the_windows_is_not_told_from_the_signal() -> None:
    kernel = np.ones(1000) / np.sqrt(1000.0)
    slow = np.convolve(RNG.standard_normal(TIME.size), kernel, "same")
    assert noise_floor(Series(TIME, SMOOTH + slow)) < 0.5


def test_a_signal_with_a_corner_every_few_seconds_is_not_noise() -> None:
    hold = np.repeat(np.random.default_rng(7).integers(0, 2, 24), 40)
    signal = 60.0 * np.convolve(np.exp(-np.arange(960) / 200.0) / 200.0, hold)[:960]
    noisy = signal + 0.06 * np.random.default_rng(8).standard_normal(960)
    assert noise_floor(Series(0.1 * np.arange(960), noisy)) == pytest.approx(0.06, rel=0.3)
