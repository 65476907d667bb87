# SPDX-License-Identifier: Apache-2.0
"""Limits and known values of the equilibrium and dynamic models."""

import numba
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from lce_model import Model, default_model, simulate
from lce_model.deformation.domains import DOMAINS, NODES
from lce_model.deformation.dynamic import Branch, _advance, _advance_most
from lce_model.deformation.vector_math import exponential
from lce_model.landau import clearing_temperature, wells

Floats = NDArray[np.float64]


def loop(model: Model, path_k: Floats) -> Floats:
    return simulate(model, np.arange(path_k.size) * 0.01, None, temperature_k=path_k).displacement_m


def up_and_down(low: float, high: float, step: float = 0.05) -> Floats:
    up = np.arange(low, high, step)
    return np.concatenate([up, up[-2::-1]])


@pytest.fixture
def equilibrium() -> Model:
    return default_model("none", "equilibrium")


@pytest.fixture
def dynamic() -> Model:
    return default_model("none", "dynamic")


def test_equilibrium_saturates_at_the_limit_of_section_6_5_1(equilibrium: Model) -> None:
    d = loop(equilibrium, up_and_down(295.0, 360.0))
    assert d.max() == pytest.approx(0.010 * (1.0 - 2.91 ** (-1.0 / 3.0)), rel=1e-9)
    assert d.max() == pytest.approx(2.996e-3, abs=5e-7)


def test_equilibrium_is_continuous_and_monotone_on_both_branches(equilibrium: Model) -> None:
    path = up_and_down(285.0, 350.0, 0.01)
    d = loop(equilibrium, path)
    turn = path.argmax()
    assert np.all(np.diff(d[:turn]) >= -1e-9)
    assert np.all(np.diff(d[turn + 1 :]) <= 1e-9)
    assert np.abs(np.diff(d[:turn])).max() < 5e-6
    assert np.abs(np.diff(d[turn + 1 :])).max() < 5e-6


def test_the_widths_as_printed_would_jump_at_t_star(equilibrium: Model) -> None:
    """Why (4.12) is used with its widths exchanged: x of the printed form is 0 just above T* and 1 below."""
    above, below = 305.001, 304.999
    corrected = simulate(equilibrium, [0.0, 1.0], None, temperature_k=[below, above])
    assert corrected.order[0] == pytest.approx(corrected.order[1], rel=1e-3)
    a0, b, c, ratio = 5.58e-22, 7.70e-20, 7.91e-20, 10.60 / 1.68
    root = np.sqrt(b * b - 4.0 * a0 * (above - 305.0) * c)
    q2, q3 = (b - root) / (2.0 * c), (b + root) / (2.0 * c)
    printed_w13_over_w31 = (ratio * q2 / (q3 - q2)) ** 2
    assert printed_w13_over_w31 < 1e-6


def test_only_the_ratio_of_the_widths_matters(equilibrium: Model) -> None:
    path = up_and_down(295.0, 345.0)
    scaled = equilibrium.set({"equilibrium.a1_r": 3.36, "equilibrium.a3_r": 21.2})
    np.testing.assert_allclose(loop(scaled, path), loop(equilibrium, path), rtol=0.0, atol=1e-15)


def test_dynamic_runs_from_one_phase_to_the_other_as_computed_from_5_10(dynamic: Model) -> None:
    path = up_and_down(300.0, 390.0)
    order = simulate(dynamic, np.arange(path.size) * 0.01, None, temperature_k=path).order
    turn = path.argmax()
    t1_heating = clearing_temperature(2.3e-22, 3.5e-20, 2.0e-20, 307.0)
    t1_cooling = clearing_temperature(6.0e-22, 4.5e-20, 2.6e-20, 307.0)
    assert t1_heating == pytest.approx(373.6, abs=0.1)
    assert t1_cooling == pytest.approx(339.5, abs=0.1)
    assert order[0] > 1.7
    assert np.all(order[:turn][path[:turn] > t1_heating + 1.0] < 1e-6)
    assert np.all(order[turn:][path[turn:] > t1_cooling] < 1e-6)
    assert order[-1] > 1.0


def test_dynamic_starts_at_stretch_one(dynamic: Model) -> None:
    assert loop(dynamic, np.array([300.0, 300.0]))[0] == pytest.approx(0.0, abs=1e-12)


def test_dynamic_depends_on_the_path_and_not_on_its_speed(dynamic: Model) -> None:
    path = up_and_down(300.0, 380.0)
    slow = simulate(dynamic, np.arange(path.size) * 10.0, None, temperature_k=path).displacement_m
    np.testing.assert_array_equal(slow, loop(dynamic, path))


def test_dynamic_does_not_jump_at_its_boundaries(dynamic: Model) -> None:
    path = up_and_down(300.0, 390.0, 0.002)
    d = loop(dynamic, path)
    turn = path.argmax()
    steps = np.abs(np.diff(d))
    assert np.delete(steps, [turn - 1, turn]).max() < 2e-6


def test_with_a_large_spinodal_rate_x_is_1_below_t_star_and_0_above_t1(dynamic: Model) -> None:
    """§5.1 to the letter, on cooling: from above both T1, and turned between that of heating and that of cooling."""
    jumps = dynamic.set({"dynamic.spinodal": 1e4})
    a0, b, c, t_star = 6.0e-22, 4.5e-20, 2.6e-20, 307.0
    for top in (390.0, 345.0):
        path = np.concatenate([np.arange(300.0, top, 0.05), np.arange(top, 300.0, -0.05)])
        turn, time = path.argmax() + 1, np.arange(path.size) * 0.01
        order, slow = (simulate(m, time, None, temperature_k=path).order[turn:] for m in (jumps, dynamic))
        cooling = path[turn:]
        below, above = cooling < t_star - 0.05, cooling > clearing_temperature(a0, b, c, t_star)
        nematic = np.array([wells(t, a0, b, c, t_star)[1] for t in cooling])
        np.testing.assert_allclose(order[above], 0.0, atol=1e-9)
        np.testing.assert_allclose(order[below], nematic[below], rtol=1e-9)
        assert slow[below][0] < 0.9 * nematic[below][0]


def test_a_spinodal_rate_depends_on_the_path_and_not_on_its_steps(dynamic: Model) -> None:
    rate = dynamic.set({"dynamic.spinodal": 0.7})
    coarse, fine = (loop(rate, up_and_down(300.0, 390.0, step)) for step in (1.0, 0.05))
    np.testing.assert_allclose(coarse[: coarse.size // 2], fine[: fine.size // 2 : 20][: coarse.size // 2], atol=2e-6)
    np.testing.assert_allclose(coarse[::-1][: coarse.size // 2], fine[::-20][: coarse.size // 2], atol=2e-6)


def test_dynamic_solves_its_equation_as_well_as_lsoda(dynamic: Model) -> None:
    """(5.8) written again, with NumPy, and given to SciPy."""
    p = {v.name: v.value for v in dynamic.values}
    boltzmann = 1.380649e-23

    def rates(t: float, a0: float, b: float, c: float, f: tuple[float, float], r: tuple[float, float]) -> Floats:
        root = np.sqrt(max(b * b - 4 * a0 * (t - p["t_star"]) * c, 0.0))
        q2, q3 = max((b - root) / (2 * c), 0.0), (b + root) / (2 * c)

        def energy(q: float) -> float:
            return a0 * (t - p["t_star"]) * q**2 / 2 - b * q**3 / 3 + c * q**4 / 4

        gap, e2, e3 = q3 - q2, energy(q2), energy(q3)
        return np.array(
            [
                (f[0] * gap + f[1] * gap**2) * np.exp(-e2 / (boltzmann * t)),
                (r[0] * q2 + r[1] * q2**2) * np.exp(-(e2 - e3) / (boltzmann * t)),
            ]
        )

    def heating(t: float, x: Floats) -> Floats:
        w13, w31 = rates(t, p["a0_r"], p["b_r"], p["c_r"], (p["cf1_r"], 0.0), (p["cr1_r"], p["cr2_r"]))
        return w13 * (1 - x) - w31 * x

    path = np.arange(300.0, 372.0, 0.05)
    reference = solve_ivp(heating, (300.0, path[-1]), [1.0], "LSODA", t_eval=path, rtol=1e-11, atol=1e-13)
    out = simulate(dynamic, np.arange(path.size) * 0.01, None, temperature_k=path)
    root = np.sqrt(np.maximum(p["b_r"] ** 2 - 4 * p["a0_r"] * (path - p["t_star"]) * p["c_r"], 0.0))
    np.testing.assert_allclose(out.order, reference.y[0] * (p["b_r"] + root) / (2 * p["c_r"]), atol=1e-6)


def test_reversals_within_the_deadband_do_not_change_the_branch(equilibrium: Model) -> None:
    path = np.array([300.0, 320.0, 319.9, 320.1, 318.0])
    out = simulate(equilibrium, np.arange(5.0), None, temperature_k=path, deadband_k=0.5)
    assert out.direction.tolist() == [1.0, 1.0, 1.0, 1.0, -1.0]
    assert simulate(equilibrium, np.arange(5.0), None, temperature_k=path).direction.tolist() == [1, 1, -1, 1, -1]


def test_all_domains_at_once_are_where_each_of_them_would_be() -> None:
    """On both branches, from slow rates to fast ones, inside the loop and beyond T* and T1."""
    rng = np.random.default_rng(0)
    one, many = (numba.njit(error_model="numpy")(f) for f in (_advance, _advance_most))
    compared = 0
    for _ in range(300):
        a0, b, c = 2.5e-22 * rng.uniform(0.8, 3.0), 4e-20 * rng.uniform(0.8, 1.2), 2.2e-20 * rng.uniform(0.8, 1.2)
        rates = np.exp(rng.uniform(np.log([0.1, 1e-5, 1.0, 1e-6]), np.log([50.0, 10.0, 2000.0, 10.0])))
        branch = Branch(a0, b, c, *map(float, rates))
        begin, spinodal, x = 307.0 + 30.0 * rng.random(), float(rng.choice([0.0, 0.7, 1e4])), rng.random(DOMAINS)
        end, after = begin + rng.normal(0.0, 0.3), np.empty(DOMAINS)
        many(x, after, begin, end, 307.0, 4.0, branch, spinodal)
        alone = [one(x[i], begin, end, 307.0 + 4.0 * NODES[i], branch, spinodal) for i in range(DOMAINS)]
        done = np.isfinite(after)
        compared += int(done.sum())
        np.testing.assert_allclose(after[done], np.array(alone)[done], rtol=0.0, atol=1e-12)
    assert compared > 0.8 * 300 * DOMAINS


def test_the_exponential_of_several_at_once_is_as_good_as_that_of_one() -> None:
    a = np.linspace(-699.0, 700.0, 20_001)
    compiled = numba.njit(error_model="numpy")(exponential)
    np.testing.assert_allclose([compiled(value) for value in a], np.exp(a), rtol=2e-14)
    assert compiled(0.0) == 1.0 and 0.0 < compiled(-1e6) < 1e-300
