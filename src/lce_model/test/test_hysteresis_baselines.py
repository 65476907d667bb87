# SPDX-License-Identifier: Apache-2.0
"""The baselines without physics: Prandtl–Ishlinskii and Bouc–Wen."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from lce_model import Model, default_model, simulate
from lce_model.deformation import bouc_wen
from lce_model.inverse import InverseChart

Floats = NDArray[np.float64]


def stretch(model: Model, path_k: Floats) -> Floats:
    d = simulate(model, np.arange(path_k.size) * 0.01, None, temperature_k=path_k).displacement_m
    return 1.0 - d / model["strip.length"]


@pytest.mark.parametrize("name", ["prandtl_ishlinskii", "bouc_wen"])
def test_at_rest_the_stretch_is_one(name: str) -> None:
    assert stretch(default_model("none", name), np.array([301.15, 301.15])) == pytest.approx([1.0, 1.0], abs=1e-12)


@pytest.mark.parametrize("name", ["prandtl_ishlinskii", "bouc_wen"])
def test_speed_does_not_matter_and_the_loop_opens(name: str) -> None:
    model = default_model("none", name)
    path = np.concatenate([np.linspace(301.15, 370.0, 500), np.linspace(370.0, 301.15, 500)])
    fast, slow = (simulate(model, np.arange(1000) * dt, None, temperature_k=path) for dt in (0.01, 10.0))
    np.testing.assert_array_equal(fast.displacement_m, slow.displacement_m)
    assert fast.displacement_m[750] > fast.displacement_m[250] + 2e-4


def test_a_minor_loop_of_plays_closes_exactly() -> None:
    model = default_model("none", "prandtl_ishlinskii")
    leg = np.linspace(320.0, 335.0, 200)
    path = np.concatenate([np.linspace(301.15, 335.0, 400), leg[::-1], leg, leg[::-1], leg])
    path_stretch = stretch(model, path)
    assert path_stretch[-1] == pytest.approx(path_stretch[-401], abs=1e-14)


def test_the_inverse_chart_reads_a_baseline_too() -> None:
    model = default_model("none", "prandtl_ishlinskii")
    chart = InverseChart(model)
    path = np.linspace(290.0, chart.temperature_k(0.002, "heating"), 4000)
    assert 0.010 * (1.0 - stretch(model, path)[-1]) == pytest.approx(0.002, abs=2e-6)


def test_bouc_wen_solves_its_equation() -> None:
    """The equation as printed, given to SciPy along a path of γ."""
    beta, shape = 4.0, 0.3
    corners = [0.0, 0.8, 0.3, 0.7, 0.1]
    h = exact = 0.0
    for start, end in pairwise(corners):
        sign = np.sign(end - start)

        def slope(u: float, y: Floats, sign: float = sign) -> Floats:
            return np.asarray(sign - beta * y - shape * beta * sign * np.abs(y))

        exact = float(solve_ivp(slope, (0.0, abs(end - start)), [exact], rtol=1e-10, atol=1e-12).y[0, -1])
        h = bouc_wen._follow(h, end - start, beta, shape)
        assert h == pytest.approx(exact, abs=1e-8)
