# SPDX-License-Identifier: Apache-2.0
"""The joint simulation P→T→d, whole and step by step."""

import numpy as np
import pytest

from lce_data.channels import AMBIENT, LOAD
from lce_data.errors import LceError
from lce_model import Model, Stepper, default_model, simulate

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


INPUTS = {LOAD: 0.05 + 0.02 * np.sin(TIME / 5.0), AMBIENT: 300.0 + 3.0 * np.sin(TIME / 9.0)}
"""Load [N] and room temperature [K]."""


def loaded(deformation: str = "equilibrium") -> Model:
    """A strip that feels the load and the room."""
    strengths = {"load_shift.shift": 40.0, "load_stretch.compliance": 5e-3, "room_temperature.share": 0.8}
    return default_model("lumped", deformation).configured(strengths)


@pytest.mark.parametrize("deformation", ["equilibrium", "kinetic"])
def test_stepping_with_inputs_gives_the_same_numbers_as_the_whole_run(deformation: str) -> None:
    model = loaded(deformation)
    assert model.inputs == (AMBIENT, LOAD)
    whole = simulate(model, TIME, PULSE, inputs=INPUTS)
    strip = Stepper(model, inputs={channel: float(value[0]) for channel, value in INPUTS.items()})
    assert strip.temperature_k == whole.temperature_k[0] == pytest.approx(301.15 + 0.8 * (300.0 - 301.15))
    for i in range(1, 2000):
        strip.set_inputs({channel: float(value[i]) for channel, value in INPUTS.items()})
        strip.step(float(PULSE[i - 1]), float(TIME[i] - TIME[i - 1]))
    assert strip.signal("load") == INPUTS[LOAD][1999]
    assert strip.temperature_k == whole.temperature_k[1999]
    assert strip.displacement_m == whole.displacement_m[1999]
    twin = strip.copy()
    twin.set_inputs({LOAD: 1.0})
    for each in (strip, twin):
        each.step(0.0, 0.01)
    assert twin.displacement_m < strip.displacement_m - 4e-3


def test_one_number_is_an_input_that_does_not_change() -> None:
    model = loaded()
    one, many = (simulate(model, TIME, PULSE, inputs={LOAD: load}) for load in (0.1, np.full(TIME.size, 0.1)))
    np.testing.assert_array_equal(one.displacement_m, many.displacement_m)


def test_without_a_load_and_a_room_the_strip_is_at_their_references() -> None:
    model, bare = loaded(), simulate(default_model("lumped", "equilibrium"), TIME, PULSE)
    np.testing.assert_array_equal(simulate(model, TIME, PULSE).displacement_m, bare.displacement_m)
    at_reference = simulate(model, TIME, PULSE, inputs={LOAD: 0.0, AMBIENT: 301.15})
    np.testing.assert_array_equal(at_reference.displacement_m, bare.displacement_m)


@pytest.mark.parametrize("load", [np.nan, [0.1, 0.2], np.full(TIME.size, np.inf)])
def test_an_input_that_is_no_series_is_refused(load: object) -> None:
    with pytest.raises(LceError, match="load must be 6000 finite numbers"):
        simulate(loaded(), TIME, PULSE, inputs={LOAD: np.asarray(load)})


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
