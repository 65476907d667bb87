# SPDX-License-Identifier: Apache-2.0
"""The free-energy landscape of Figs. 4.3 and 4.4, and the boundary temperatures (4.22)."""

import numpy as np
import pytest

from lce_model.landau import clearing_temperature, free_energy, wells

A0, B, C_R, C_C = 5.58e-22, 7.70e-20, 7.91e-20, 6.76e-20
T_STAR_R, T_STAR_C = 305.0, 291.9


def minima_and_maxima(temperature: float) -> tuple[list[float], list[float]]:
    q = np.linspace(-0.5, 1.5, 200001)
    f = np.array([free_energy(x, temperature, A0, B, C_R, T_STAR_R) for x in q[::20]])
    q = q[::20]
    inner = np.arange(1, f.size - 1)
    low = inner[(f[1:-1] < f[:-2]) & (f[1:-1] < f[2:])]
    high = inner[(f[1:-1] > f[:-2]) & (f[1:-1] > f[2:])]
    return [float(x) for x in q[low]], [float(x) for x in q[high]]


def test_boundary_temperatures_are_those_of_4_22() -> None:
    assert clearing_temperature(A0, B, C_R, T_STAR_R) == pytest.approx(338.6, abs=0.05)
    assert clearing_temperature(A0, B, C_C, T_STAR_C) == pytest.approx(331.2, abs=0.05)


def test_curve_a_above_t1_has_the_isotropic_well_only() -> None:
    low, high = minima_and_maxima(339.5)
    assert low == pytest.approx([0.0], abs=1e-3)
    assert high == []


def test_curve_b_between_has_two_wells_and_a_barrier_where_4_3_puts_them() -> None:
    low, high = minima_and_maxima(325.0)
    q2, q3 = wells(325.0, A0, B, C_R, T_STAR_R)
    assert low == pytest.approx([0.0, q3], abs=1e-3)
    assert high == pytest.approx([q2], abs=1e-3)
    assert 0.0 < q2 < q3
    assert free_energy(q2, 325.0, A0, B, C_R, T_STAR_R) > max(0.0, free_energy(q3, 325.0, A0, B, C_R, T_STAR_R))


def test_curve_c_below_t2_has_no_well_at_zero() -> None:
    low, high = minima_and_maxima(300.0)
    assert 0.0 not in [round(x, 3) for x in low]
    assert high == pytest.approx([0.0], abs=1e-3)
    assert low[-1] == pytest.approx(wells(300.0, A0, B, C_R, T_STAR_R)[1], abs=1e-3)


def test_curve_d_has_equal_wells() -> None:
    t3 = T_STAR_R + 2.0 * B**2 / (9.0 * A0 * C_R)
    q3 = wells(t3, A0, B, C_R, T_STAR_R)[1]
    assert free_energy(q3, t3, A0, B, C_R, T_STAR_R) == pytest.approx(0.0, abs=1e-30)


def test_the_wells_merge_at_t1() -> None:
    q2, q3 = wells(clearing_temperature(A0, B, C_R, T_STAR_R), A0, B, C_R, T_STAR_R)
    assert q2 == pytest.approx(q3, rel=1e-6)
    assert q3 == pytest.approx(B / (2.0 * C_R), rel=1e-6)
