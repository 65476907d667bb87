# SPDX-License-Identifier: Apache-2.0
"""Bounds of a search: widened by the user, and by the data."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lce_analysis.identification import fit
from lce_analysis.identification.bounds import bounded, reaching
from lce_data.errors import LceError
from lce_data.run import Run, Series
from lce_model import Model, default_model
from lce_model.effects import find

NOISE_K = 0.05


def heater(lag_s: float, ambient_k: float = 296.0, gain: float = 60.0, tau: float = 150.0) -> Run:
    """A step of the power and its end, seen by a sensor that is late; solved by scipy."""
    time = np.arange(0.0, 900.0, 2.0)
    power = np.where(time < 450.0, 0.5, 0.1)

    def slope(t: float, y: np.ndarray) -> list[float]:
        return [(gain * (0.5 if t < 450.0 else 0.1) - (y[0] - ambient_k)) / tau, (y[0] - y[1]) / lag_s]

    found = solve_ivp(slope, (0.0, 900.0), [ambient_k, ambient_k], t_eval=time, max_step=2.0, rtol=1e-8)
    noise = NOISE_K * np.random.default_rng(3).standard_normal(time.size)
    return Run.of("heater", Series(time, power), Series(time, found.y[1] + noise), sha256="heater")


def test_a_second_mass_is_found_by_a_fit_and_a_camera_lag_within_wider_bounds() -> None:
    run = heater(lag_s=30.0)
    massive = fit(default_model("lumped", "none", ("second_mass",)), [run]).model
    late = default_model("lumped", "none", ("camera_lag",)).hold({"camera_lag.tau": (0.0, 60.0)})
    late = fit(late.fix(["camera_lag.delay"]), [run]).model
    for model, key in ((massive, "second_mass.tau"), (late, "camera_lag.tau")):
        assert model[key] == pytest.approx(30.0, abs=1.0)
        assert model["lumped.tau"] == pytest.approx(150.0, abs=2.0)
        assert model["lumped.gain"] == pytest.approx(60.0, abs=0.5)


def test_temperatures_are_searched_as_far_as_the_data_reach() -> None:
    run = heater(lag_s=1.0, ambient_k=500.0)
    model = default_model("lumped", "kinetic")
    there = reaching(model, [run])
    bounds = {v.key: (v.lower, v.upper) for v in there.values}
    assert bounds["ambient.t_env"] == pytest.approx((250.0, 600.0), abs=2.0)
    assert bounds["kinetic.t_c"] == pytest.approx((250.0, 600.0 + 28.0), abs=5.0)
    assert bounds["kinetic.half_width"] == (0.01, 200.0)
    assert fit(default_model("lumped", "none"), [run]).model["ambient.t_env"] == pytest.approx(500.0, abs=0.5)


def test_a_strip_of_the_bench_and_bounds_that_somebody_set_stay() -> None:
    assert reaching(default_model(), [heater(1.0)]) == default_model()
    held = default_model("lumped", "none").hold({"ambient.t_env": (290.0, 310.0)})
    assert reaching(held, [heater(1.0, ambient_k=500.0)]) == held


def test_bounds_of_the_model_and_of_effects_that_it_may_be_given() -> None:
    asked = {"lumped.tau": (5.0, 50.0), "camera_lag.tau": (0.0, 60.0)}
    model, (lag, creep) = bounded(default_model(), [find("camera_lag"), find("creep")], asked)
    assert _bounds(model, "lumped.tau") == (5.0, 50.0)
    assert creep == find("creep")
    assert _bounds(model.add(lag), "camera_lag.tau") == (0.0, 60.0)
    assert _bounds(model.add("camera_lag"), "camera_lag.tau") == (0.0, 2.0)


def _bounds(model: Model, key: str) -> tuple[float, float]:
    value = model.values[model.index(key)]
    return value.lower, value.upper


@pytest.mark.parametrize(
    ("key", "ends", "message"),
    [
        ("creep.tau_v", (0.1, 1.0), "bounds of creep: neither the model nor the effects have it"),
        ("camera_lag.lag", (0.1, 1.0), "effect camera_lag: no parameter 'lag'; it has tau, delay"),
        ("camera_lag.tau", (-1.0, 1.0), "parameter tau: the lower bound, -1 s, must be at least 0"),
        ("camera_lag.tau", (1.0, 3.0), r"parameter tau: 0 s is outside \[1, 3\] s"),
    ],
)
def test_bounds_that_cannot_be_are_refused(key: str, ends: tuple[float, float], message: str) -> None:
    with pytest.raises(LceError, match=message):
        bounded(default_model(), [find("camera_lag")], {key: ends})
