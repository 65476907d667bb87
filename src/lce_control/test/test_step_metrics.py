# SPDX-License-Identifier: Apache-2.0
"""The figures of a step, on steps whose figures are known."""

import math

import numpy as np
import pytest

from lce_control.step_metrics import step_metrics
from lce_data.errors import LceError

T = np.arange(0.0, 60.0, 0.01)


def test_an_exponential_rise_has_the_times_of_its_logarithms() -> None:
    m = step_metrics(T, 2e-3 * (1.0 - np.exp(-T / 3.0)), 2e-3)
    assert m.rise_time_s == pytest.approx(3.0 * math.log(5.0), abs=0.01)
    assert m.settling_time_s == pytest.approx(3.0 * math.log(50.0), abs=0.01)
    assert m.overshoot == 0.0 and m.rmse_after_30s < 1e-4


def test_overshoot_and_late_error_are_fractions_of_the_target() -> None:
    d = np.where(T < 1.0, 0.0, np.where(T < 5.0, 1.1e-3, 1.005e-3))
    m = step_metrics(T, d, 1e-3)
    assert (m.rise_time_s, m.settling_time_s) == (pytest.approx(1.0), pytest.approx(5.0))
    assert m.overshoot == pytest.approx(0.1) and m.rmse_after_30s == pytest.approx(0.005)


def test_a_step_down_overshoots_below() -> None:
    m = step_metrics(T, np.where(T < 2.0, 2e-3, 0.97e-3), 1e-3)
    assert m.rise_time_s == pytest.approx(2.0) and m.overshoot == pytest.approx(0.03)
    assert math.isnan(m.settling_time_s)


def test_what_did_not_happen_is_nan() -> None:
    m = step_metrics(T[:1000], np.full(1000, 0.5e-3), 1e-3)
    assert math.isnan(m.rise_time_s) and math.isnan(m.settling_time_s) and math.isnan(m.rmse_after_30s)


@pytest.mark.parametrize("target_m", [0.0, -1e-3, math.nan])
def test_a_target_that_is_no_contraction_has_no_figures(target_m: float) -> None:
    with pytest.raises(LceError, match="target"):
        step_metrics(T, T, target_m)


def test_series_of_different_length_are_refused() -> None:
    with pytest.raises(LceError, match="one displacement for each time"):
        step_metrics(T, T[1:], 1e-3)
