# SPDX-License-Identifier: Apache-2.0
"""Closures: an unknown function of a covariate, at every place, of every covariate, in every form."""

import inspect

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_model import Model, default_model, simulate
from lce_model.closures import PLACES, Place, closure
from lce_model.closures.covariates import COVARIATES, NUMBER
from lce_model.closures.forms import FORMS, KNOTS, value
from lce_model.lag import lagged
from lce_model.simulation import Trajectory

Floats = NDArray[np.float64]

TIME = np.arange(0.0, 60.0, 0.01)
POWER = np.where((TIME % 30.0 > 2.0) & (TIME % 30.0 < 14.0), 1.4, 0.2)
TAU = 3.0
LINEAR = 2.0


@pytest.fixture(scope="module")
def model() -> Model:
    found = default_model("lumped", "equilibrium")
    for place in PLACES:
        found = found.add(closure(place.name))
    return found


@pytest.fixture(scope="module")
def strip() -> Trajectory:
    return simulate(default_model("lumped", "equilibrium"), TIME, POWER)


def test_a_closure_that_is_zero_changes_nothing(model: Model, strip: Trajectory) -> None:
    with_closures = simulate(model, TIME, POWER)
    np.testing.assert_array_equal(with_closures.measured_temperature_k, strip.measured_temperature_k)
    np.testing.assert_array_equal(with_closures.measured_displacement_m, strip.measured_displacement_m)


def _expected(name: str, strip: Trajectory) -> Floats:
    warm, moved, branch = strip.temperature_k, strip.displacement_m, strip.direction
    dt = np.diff(TIME)

    def so_far(steps: Floats) -> Floats:
        return np.concatenate([[0.0], np.cumsum(steps)])

    # At the end of a step the power is that which was held over it.
    held = np.concatenate([[0.0], POWER[:-1]])
    return {
        "temperature": warm,
        "rate": np.concatenate([[0.0], np.diff(warm) / dt]),
        "power": held,
        "order": strip.order,
        "displacement": moved,
        "time": TIME,
        "dose": so_far(POWER[:-1] * dt),
        "path": so_far(np.abs(np.diff(warm))),
        "branch": branch,
        "cycle": so_far((np.diff(branch) > 0.0).astype(float)),
        "lagged_temperature": warm - lagged(TIME, warm, TAU, False),
        "lagged_power": held - lagged(TIME, held, TAU, True),
        "lagged_displacement": moved - lagged(TIME, moved, TAU, False),
        "late_power": lagged(TIME, held, TAU, True),
        "displacement_path": so_far(np.abs(np.diff(moved))),
    }[name]


@pytest.mark.parametrize("name", [covariate.name for covariate in COVARIATES])
def test_the_kernel_follows_every_covariate(name: str, model: Model, strip: Trajectory) -> None:
    settings = {"strength": 1e-3, "covariate": NUMBER[name], "form": LINEAR, "tau": TAU}
    seen = simulate(model.set({f"closure_displacement_sensor.{k}": v for k, v in settings.items()}), TIME, POWER)
    change = seen.measured_displacement_m - strip.measured_displacement_m
    expected = 1e-3 * _expected(name, strip)
    np.testing.assert_allclose(change, expected, rtol=1e-9, atol=1e-6 * np.ptp(expected))


def test_a_lag_is_that_of_its_differential_equation() -> None:
    late = lagged(TIME, np.sin(TIME), 2.0, False)
    steady = (np.sin(TIME) - 2.0 * np.cos(TIME)) / 5.0
    np.testing.assert_allclose(late, steady + 0.4 * np.exp(-TIME / 2.0), atol=1e-5)


@pytest.mark.parametrize("number", range(1, len(FORMS) + 1), ids=[form.name for form in FORMS])
def test_every_form_has_its_number(number: int) -> None:
    function = FORMS[number - 1].function
    z, z0, a, b = 305.0, 300.0, 2.5, 1.5
    known = {"x": z - z0, "z": z, "z0": z0, "a": a, "b": b}
    expected = function(**{name: known[name] for name in inspect.signature(function).parameters})
    assert value(float(number), z, z0, a, b, 0.0, 1.0, np.zeros(KNOTS)) == expected != 0.0
    assert set(FORMS[number - 1].numbers) == {"a", "b"} & set(FORMS[number - 1].arguments)


def test_the_curve_is_straight_between_knots_and_holds_at_its_ends() -> None:
    w = np.random.default_rng(1).standard_normal(KNOTS)
    z = np.linspace(-1.0, 3.0, 41)
    found = [value(0.0, x, 0.0, 1.0, 0.0, 0.0, 2.0, w) for x in z]
    np.testing.assert_allclose(found, np.interp(z, np.linspace(0.0, 2.0, KNOTS), w), atol=1e-12)
    assert value(0.0, float("nan"), 0.0, 1.0, 0.0, 0.0, 2.0, w) == 0.0


@pytest.mark.parametrize("place", PLACES, ids=[place.name for place in PLACES])
def test_a_constant_acts_at_its_place(place: Place, model: Model, strip: Trajectory) -> None:
    name = place.name
    size = {"light": 0.1, "heat": 0.1, "order": 1.0, "strain": 1e-4}.get(name, 1e-4 if "disp" in name else 1.0)
    term = f"closure_{name}"
    seen = simulate(model.set({f"{term}.strength": size, f"{term}.form": 1.0}), TIME, POWER)
    warmer = seen.measured_temperature_k - strip.measured_temperature_k
    further = seen.measured_displacement_m - strip.measured_displacement_m
    lumped = default_model("lumped", "none")
    if name == "heat":
        rising = -np.expm1(-TIME / lumped["lumped.tau"])
        np.testing.assert_allclose(warmer, 0.1 * lumped["lumped.tau"] * rising, atol=1e-9)
    elif name == "light":
        np.testing.assert_allclose(warmer, 0.1 * (strip.temperature_k - strip.temperature_k[0]), atol=1e-9)
    elif name == "temperature_sensor":
        np.testing.assert_allclose(warmer, 1.0, atol=1e-9)
    else:
        assert not warmer.any()
        if name != "order":
            np.testing.assert_allclose(further, 1e-4, atol=1e-12)
    assert further.any() or name == "temperature_sensor"
