# SPDX-License-Identifier: Apache-2.0
"""The joint simulation P→T→d, whole and step by step."""

import numpy as np
import pytest

from lce_data.errors import LceError
from lce_model import Stepper, default_model, simulate

TIME = np.arange(0.0, 60.0, 0.01)
PULSE = np.where(TIME < 30.0, 0.2 * np.sin(np.pi / 60.0 * TIME) + 1.5, 0.0)


def test_lumped_heating_is_the_exponential() -> None:
    model = default_model("lumped", "none")
    out = simulate(model, TIME, np.full_like(TIME, 1.5))
    np.testing.assert_allclose(out.temperature_k, 301.15 + 45.0 * (1.0 - np.exp(-TIME / 18.0)), rtol=1e-12)
    assert np.isnan(out.displacement_m).all()


def test_lumped_is_exact_at_any_step() -> None:
    model = default_model("lumped", "none")
    coarse = np.array([0.0, 7.0, 11.0, 59.0])
    fine = simulate(model, np.arange(0.0, 60.0, 1.0), np.ones(60))
    assert simulate(model, coarse, np.ones(4)).temperature_k[-1] == pytest.approx(fine.temperature_k[59], rel=1e-13)


@pytest.mark.parametrize("deformation", ["equilibrium", "dynamic"])
def test_stepping_gives_the_same_numbers_as_the_whole_run(deformation: str) -> None:
    model = default_model("lumped", deformation)
    whole = simulate(model, TIME, PULSE)
    strip = Stepper(model)
    for i in range(1, TIME.size):
        strip.step(float(PULSE[i - 1]), float(TIME[i] - TIME[i - 1]))
    assert strip.temperature_k == whole.temperature_k[-1]
    assert strip.displacement_m == whole.displacement_m[-1]


def test_a_given_temperature_replaces_the_thermal_stage() -> None:
    model = default_model("lumped", "equilibrium")
    free = simulate(model, TIME, PULSE)
    driven = simulate(model, TIME, None, temperature_k=free.temperature_k)
    np.testing.assert_array_equal(driven.displacement_m, free.displacement_m)


def test_the_strip_starts_where_it_is_told() -> None:
    out = simulate(default_model(), TIME, np.zeros_like(TIME), initial_temperature_k=330.0)
    assert out.temperature_k[0] == 330.0
    assert out.temperature_k[-1] < 303.0


@pytest.mark.parametrize(
    ("time", "power", "message"),
    [
        ([0.0, 1.0, 0.5], [0.0, 0.0, 0.0], "strictly increasing"),
        ([0.0, float("nan")], [0.0, 0.0], "strictly increasing"),
        ([0.0, 1.0], [0.0], "power must be 2 finite numbers"),
        ([0.0, 1.0], [0.0, float("inf")], "power must be 2 finite numbers"),
    ],
)
def test_input_that_is_no_series_is_refused(time: list[float], power: list[float], message: str) -> None:
    with pytest.raises(LceError, match=message):
        simulate(default_model(), time, power)


@pytest.mark.parametrize(("power", "dt"), [(float("nan"), 0.01), (-1.0, 0.01), (1.0, -0.01), (1.0, float("inf"))])
def test_a_step_that_is_not_physical_is_refused(power: float, dt: float) -> None:
    with pytest.raises(LceError, match="cannot step"):
        Stepper(default_model()).step(power, dt)


def test_a_model_without_thermal_stage_needs_a_temperature() -> None:
    with pytest.raises(LceError, match="measured temperature"):
        simulate(default_model("none", "dynamic"), TIME, PULSE)
