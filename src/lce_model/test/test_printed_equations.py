# SPDX-License-Identifier: Apache-2.0
"""What the dissertation's equations give as they are printed.

docs/explanation/physics.md says why the models depart from them.
"""

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_model import Model, Trajectory, default_model, simulate
from lce_model.constants import BOLTZMANN
from lce_model.landau import clearing_temperature, free_energy, wells

Floats = NDArray[np.float64]


@pytest.fixture
def equilibrium() -> Model:
    return default_model("none", "equilibrium")


@pytest.fixture
def dynamic() -> Model:
    return default_model("none", "dynamic")


def along(model: Model, *path_k: Floats | list[float]) -> Trajectory:
    """The model driven along a path of temperatures."""
    path = np.concatenate(path_k)
    return simulate(model, np.arange(path.size, dtype=float), None, temperature_k=path)


def test_x_of_4_13_as_printed_runs_the_wrong_way() -> None:
    """0 just above T*, where it is 1 below, and 1 just below T1, where it is 0 above."""
    a0, b, c, t_star, a1, a3 = 5.58e-22, 7.70e-20, 7.91e-20, 305.0, 1.68, 10.60

    def printed(t: float) -> float:
        q2, q3 = wells(t, a0, b, c, t_star)
        barrier, depth = (free_energy(q, t, a0, b, c, t_star) for q in (q2, q3))
        w13 = (q2 / a1) ** 2 * np.exp(-barrier / (BOLTZMANN * t))
        w31 = ((q3 - q2) / a3) ** 2 * np.exp(-(barrier - depth) / (BOLTZMANN * t))
        return float(w13 / (w13 + w31))

    t1 = clearing_temperature(a0, b, c, t_star)
    assert printed(t_star + 0.001) < 1e-6
    assert printed(t1 - 1e-6) > 1.0 - 1e-6


def test_dx_of_5_8_as_printed_falls_on_cooling(dynamic: Model) -> None:
    """With dT < 0 the gain w13 (1 - x) dT is a loss: from the isotropic strip, x = 0, it leads below zero."""
    a0, b, c, t_star, f1, f2 = (dynamic[f"dynamic.{k}"] for k in ("a0_f", "b_f", "c_f", "t_star", "cf1_f", "cf2_f"))
    t, x, dt = 320.0, 0.0, -0.1
    q2, q3 = wells(t, a0, b, c, t_star)
    gap = q3 - q2
    w13 = (f1 * gap + f2 * gap**2) * np.exp(-free_energy(q2, t, a0, b, c, t_star) / (BOLTZMANN * t))
    assert x + w13 * (1.0 - x) * dt < 0.0
    cooled = along(dynamic, np.linspace(300.0, 390.0, 901), np.linspace(389.9, 320.0, 700))
    assert cooled.order[-1] > 0.0 == pytest.approx(cooled.order[900], abs=1e-9)


def test_x_of_5_10_is_not_1_where_the_cooling_strip_reaches_t_star(dynamic: Model) -> None:
    """What "x = 1 for T < T2" would make jump: the model lets x run on to 1 below T*."""
    cooled = along(dynamic, np.linspace(300.0, 390.0, 901), np.linspace(389.9, 300.0, 900))
    a0, b, c, t_star = (dynamic[f"dynamic.{k}"] for k in ("a0_f", "b_f", "c_f", "t_star"))

    def x_at(t: float) -> float:
        return float(cooled.order[900 + round((390.0 - t) / 0.1)] / wells(t, a0, b, c, t_star)[1])

    assert x_at(307.0) == pytest.approx(0.83, abs=0.005)
    assert x_at(300.0) > 0.999


def test_the_strip_of_5_10_would_be_elongated_at_rest_with_q0_of_1(dynamic: Model) -> None:
    order = float(along(dynamic, [300.0, 300.0]).order[0])
    alpha = dynamic["stretch_law.alpha"]
    assert ((1.0 + alpha * order) / (1.0 + alpha)) ** (1.0 / 3.0) == pytest.approx(1.18, abs=0.005)


@pytest.mark.parametrize(("deformation", "turn_k", "jump_mm"), [("equilibrium", 320.0, 0.67), ("dynamic", 340.0, 0.70)])
def test_the_displacement_jumps_where_the_branch_changes_inside_the_loop(
    deformation: str, turn_k: float, jump_mm: float
) -> None:
    """Two parameter sets, by direction, are two curves: the reversal goes from one to the other at once."""
    d = along(default_model("none", deformation), np.arange(300.0, turn_k, 0.05), [turn_k, turn_k - 1e-6])
    assert (d.displacement_m[-1] - d.displacement_m[-2]) * 1e3 == pytest.approx(jump_mm, abs=0.01)


LOOP = (np.linspace(296.0, 385.0, 300), np.linspace(384.0, 330.0, 100), np.linspace(331.0, 380.0, 100))
SCALE = 1.07


def test_the_scale_of_the_order_is_not_seen_by_the_dynamic_model(dynamic: Model) -> None:
    """Q → sQ leaves energies, rates and λ as they are: one combination of the 15 parameters is never determined."""
    powers = {"stretch_law.alpha": -1} | {
        f"dynamic.{name}": power
        for power, names in {
            -1: ("cr1_r", "cf1_r", "cr1_f", "cf1_f"),
            -2: ("a0_r", "a0_f", "cr2_r", "cf2_f"),
            -3: ("b_r", "b_f"),
            -4: ("c_r", "c_f"),
        }.items()
        for name in names
    }
    scaled = dynamic.set({key: dynamic[key] * SCALE**power for key, power in powers.items()})
    before, after = along(dynamic, *LOOP), along(scaled, *LOOP)
    np.testing.assert_allclose(after.order, SCALE * before.order, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(after.displacement_m, before.displacement_m, rtol=0.0, atol=1e-12)


def test_the_scale_of_the_order_is_set_by_q0_in_the_equilibrium_model(equilibrium: Model) -> None:
    """The same scaling is visible with Q̄0 = 1, and no longer if Q̄0 is scaled too: it must stay fixed in a fit."""
    powers = {"a0": -2, "b": -3, "c_r": -4, "c_c": -4}
    changes = {f"equilibrium.{k}": equilibrium[f"equilibrium.{k}"] * SCALE**n for k, n in powers.items()}
    changes["stretch_law.alpha"] = equilibrium["stretch_law.alpha"] / SCALE
    before = along(equilibrium, *LOOP).displacement_m
    with_fixed_q0 = along(equilibrium.set(changes), *LOOP).displacement_m
    with_scaled_q0 = along(equilibrium.set(changes | {"equilibrium.q0": SCALE}), *LOOP).displacement_m
    assert np.abs(with_fixed_q0 - before).max() > 1e-5
    np.testing.assert_allclose(with_scaled_q0, before, rtol=0.0, atol=1e-12)
