# SPDX-License-Identifier: Apache-2.0
"""Landau–de Gennes free energy of a nematic molecule, (4.1)–(4.6).

Plain functions of floats that also compile into the kernels. Temperatures in kelvin, energies in joule. With the
coefficients A0 [J/K], B [J], C [J] and T* [K]:

    F(Q) = A0 (T - T*) Q²/2 - B Q³/3 + C Q⁴/4                                                        (4.1), (4.2)

Extrema: Q1 = 0 (isotropic), Q2 (barrier), Q3 (nematic) (4.3); both wells exist for T* < T < T1 (4.4), (4.5).
"""

import math

from numba.extending import register_jitable


@register_jitable
def free_energy(q: float, temperature: float, a0: float, b: float, c: float, t_star: float) -> float:
    """F(Q) [J] of (4.1) at the order parameter ``q``."""
    return q * q * (0.5 * a0 * (temperature - t_star) + q * (0.25 * c * q - b / 3.0))


@register_jitable
def clearing_temperature(a0: float, b: float, c: float, t_star: float) -> float:
    """T1 [K] of (4.4): above it only the isotropic phase exists."""
    return t_star + b * b / (4.0 * a0 * c)


@register_jitable
def wells(temperature: float, a0: float, b: float, c: float, t_star: float) -> tuple[float, float]:
    """(Q2, Q3) of (4.3); both B/2C above T1, where the barrier and the nematic well have merged and gone."""
    root = math.sqrt(max(b * b - 4.0 * a0 * (temperature - t_star) * c, 0.0))
    return (b - root) / (2.0 * c), (b + root) / (2.0 * c)
