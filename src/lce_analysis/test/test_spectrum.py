# SPDX-License-Identifier: Apache-2.0
"""Spectra: their unit, their place on the frequency axis, and times that are not even."""

import numpy as np
import pytest

from lce_analysis.comparison.spectrum import spectrum


def test_the_square_of_the_density_integrates_to_the_variance() -> None:
    value = 3.0 * np.random.default_rng(1).standard_normal(40_000)
    found = spectrum(np.arange(value.size) / 100.0, value)
    width_hz = found.frequency_hz[1] - found.frequency_hz[0]
    assert float(np.sum(found.density**2) * width_hz) == pytest.approx(9.0, rel=0.02)
    assert found.frequency_hz[-1] == pytest.approx(50.0)


def test_a_vibration_stands_at_its_frequency_although_the_times_are_uneven() -> None:
    rng = np.random.default_rng(2)
    time_s = np.cumsum(rng.uniform(0.008, 0.012, 20_000))
    found = spectrum(time_s, 5.0 * time_s + np.sin(2.0 * np.pi * 7.0 * time_s))
    assert found.frequency_hz[np.argmax(found.density)] == pytest.approx(7.0, abs=0.05)


def test_a_short_run_has_one() -> None:
    found = spectrum(np.arange(12.0), np.cos(np.arange(12.0)))
    assert found.frequency_hz.size > 2 and np.isfinite(found.density).all()
