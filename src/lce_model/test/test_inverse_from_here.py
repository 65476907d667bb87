# SPDX-License-Identifier: Apache-2.0
"""The temperature that gives a displacement from where the strip is."""

from itertools import pairwise

import numpy as np
import pytest

from lce_model import Model, default_model, simulate
from lce_model.inverse import InverseChart, OutOfReach, temperature_from_here_k

MODELS = ["equilibrium", "dynamic", "kinetic"]


def path(*corners_k: float) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and temperatures [K] of a slow walk, at 10 Hz."""
    legs = [np.linspace(a, b, 1 + round(abs(b - a) / 0.1)) for a, b in pairwise(corners_k)]
    temperature = np.concatenate(legs)
    return 0.1 * np.arange(temperature.size), temperature


def displacement(model: Model, times: np.ndarray, temperature: np.ndarray, then_k: float) -> float:
    """Displacement [m] where the path goes on slowly to a temperature."""
    on = np.linspace(temperature[-1], then_k, 2 + int(abs(then_k - temperature[-1]) / 0.025))[1:]
    t = np.concatenate([times, times[-1] + 1.0 + np.arange(on.size)])
    d = simulate(model, t, None, temperature_k=np.concatenate([temperature, on]), deadband_k=0.3).displacement_m
    return float(d[-1])


@pytest.mark.parametrize("name", MODELS)
def test_a_cold_strip_goes_by_the_heating_branch_and_a_hot_one_by_the_cooling_branch(name: str) -> None:
    model = default_model("lumped", name)
    chart = InverseChart(model)
    assert temperature_from_here_k(model, [], [], 1.5e-3) == pytest.approx(
        chart.temperature_k(1.5e-3, "heating"), abs=0.2
    )
    assert temperature_from_here_k(model, *path(290.0, 400.0), 1.5e-3) == pytest.approx(
        chart.temperature_k(1.5e-3, "cooling"), abs=0.2
    )


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("wanted_m", [0.7e-3, 1.4e-3])
def test_the_strip_gets_there_from_inside_the_loop(name: str, wanted_m: float) -> None:
    """Heated part of the way, cooled a little: a minor loop."""
    model = default_model("lumped", name)
    middle_k = InverseChart(model).temperature_k(1.0e-3, "heating")
    times, temperature = path(300.0, middle_k, middle_k - 2.0)
    answer_k = temperature_from_here_k(model, times, temperature, wanted_m)
    assert displacement(model, times, temperature, answer_k) == pytest.approx(wanted_m, abs=1e-5)


def test_noise_of_the_camera_does_not_change_the_branch() -> None:
    model = default_model("lumped", "dynamic")
    times, temperature = path(300.0, 326.0)
    noise = np.random.default_rng(1).normal(0.0, 0.06, temperature.size)
    quiet = temperature_from_here_k(model, times, temperature, 2.5e-3)
    assert temperature_from_here_k(model, times, temperature + noise, 2.5e-3) == pytest.approx(quiet, abs=0.1)


@pytest.mark.parametrize("wanted_m", [9e-3, -1e-3, np.nan])
def test_out_of_reach_names_what_is_reached_from_here(wanted_m: float) -> None:
    model = default_model()
    times, temperature = path(300.0, 320.0)
    with pytest.raises(OutOfReach, match="out of reach") as caught:
        temperature_from_here_k(model, times, temperature, wanted_m)
    for reached_m in (caught.value.lower_m + 1e-6, caught.value.upper_m - 1e-6):
        answer_k = temperature_from_here_k(model, times, temperature, reached_m)
        assert displacement(model, times, temperature, answer_k) == pytest.approx(reached_m, abs=1e-5)
