# SPDX-License-Identifier: Apache-2.0
"""The bang-bang limit: as fast as full power, no overshoot, and held."""

import numpy as np
import pytest

from lce_control.step_metrics import step_metrics
from lce_control.tuning.bang_bang import bang_bang
from lce_model import Stepper, default_model, simulate

STRIP = default_model("lumped", "kinetic").set({"lumped.gain": 73.0, "stretch_law.alpha": 2.2})


@pytest.mark.parametrize("target_m", [1.0e-3, 3.0e-3])
def test_it_rises_as_under_full_power_and_then_stays(target_m: float) -> None:
    best = bang_bang(STRIP, target_m, 40.0)
    full = simulate(STRIP, best.time_s, np.full_like(best.time_s, 2.0))
    figures = step_metrics(best.time_s, best.displacement_m, target_m)
    assert figures.rise_time_s == pytest.approx(best.time_s[np.argmax(full.displacement_m >= 0.8 * target_m)])
    assert figures.overshoot < 1e-4 and figures.rmse_after_30s < 1e-3
    later = simulate(
        STRIP, full.time_s, np.where(full.time_s < best.time_s[np.argmax(best.power_w < 2.0)] + 0.2, 2.0, 0.0)
    )
    assert later.displacement_m.max() > target_m, "a switch 0.2 s later would overshoot, however dark it is then"


def test_it_goes_down_dark_and_holds_there() -> None:
    strip = Stepper(STRIP)
    bang_bang(strip, 2.0e-3, 20.0)
    best = bang_bang(strip, 1.0e-3, 60.0)
    figures = step_metrics(best.time_s, best.displacement_m, 1.0e-3)
    dark = best.time_s < figures.rise_time_s
    assert set(best.power_w[dark]) == {0.0}
    assert figures.overshoot < 1e-3 and figures.rmse_after_30s < 1e-3


def test_the_strip_is_not_heated_beyond_its_limit() -> None:
    best = bang_bang(STRIP, 3.0e-3, 30.0, hottest_k=335.0)
    assert 334.9 < best.temperature_k.max() <= 335.0 + 1e-6


def test_a_copy_of_a_strip_lives_on_its_own() -> None:
    strip = Stepper(STRIP)
    strip.step(2.0, 5.0)
    twin = strip.copy()
    twin.step(2.0, 1.0)
    assert twin.temperature_k > strip.temperature_k
    strip.step(2.0, 1.0)
    assert (twin.temperature_k, twin.displacement_m) == (strip.temperature_k, strip.displacement_m)
