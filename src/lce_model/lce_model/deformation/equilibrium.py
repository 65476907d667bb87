# SPDX-License-Identifier: Apache-2.0
"""Phase transition in dynamic equilibrium: Wu (2021), chapter 4, (4.1)–(4.14).

The share x of molecules in the nematic well follows from detailed balance, x = W13/(W13 + W31) (4.10), with Boltzmann
rates over the barriers of the Landau–de Gennes energy (4.11). The well widths are used as the prose and (5.2) have
them, δ13 = ((Q3−Q2)/a3)², δ31 = ((Q2−Q1)/a1)²; as printed in (4.12) x would jump at T*. C, T*, a1 and a3 have one value
on the heating branch (``_r``, the temperature rising) and another on the cooling branch (``_c``).

Only the ratio a1/a3 of each branch enters x. Where an effect spreads T* over domains, the order is the mean of theirs.
"""

import math

from numba.extending import register_jitable

from lce_model.constants import BOLTZMANN
from lce_model.deformation.domains import DOMAINS, NODES, SHARES
from lce_model.landau import clearing_temperature, free_energy, wells
from lce_model.terms import Parameter, Term


@register_jitable
def _in_equilibrium(
    temperature: float, a0: float, b: float, c: float, t_star: float, ratio: float
) -> tuple[float, float]:
    """(x, Q3) in equilibrium, with the ratio a3/a1."""
    q2, q3 = wells(temperature, a0, b, c, t_star)
    if temperature <= t_star:
        return 1.0, q3
    if temperature >= clearing_temperature(a0, b, c, t_star):
        return 0.0, q3
    # W31/W13: the barriers enter by their difference alone, E23 - E21 = -F(Q3).
    exponent = free_energy(q3, temperature, a0, b, c, t_star) / (BOLTZMANN * temperature)
    width = ratio * q2 / (q3 - q2)
    back = width * width * math.exp(min(exponent, 700.0))
    return 1.0 / (1.0 + back), q3


def step(
    order_temperature: float,
    transition_spread: float,
    direction: float,
    a0: float,
    b: float,
    c_r: float,
    c_c: float,
    t_star_r: float,
    t_star_c: float,
    a1_r: float,
    a3_r: float,
    a1_c: float,
    a3_c: float,
    q0: float,
) -> tuple[float, float, float]:
    """(x, Q3, Q̄0) at the temperature and on the branch given."""
    rising = direction > 0.0
    c = c_r if rising else c_c
    t_star = t_star_r if rising else t_star_c
    ratio = a3_r / a1_r if rising else a3_c / a1_c
    if transition_spread == 0.0:
        x, q3 = _in_equilibrium(order_temperature, a0, b, c, t_star, ratio)
        return x, q3, q0
    order = possible = 0.0
    for i in range(DOMAINS):
        x, q3 = _in_equilibrium(order_temperature, a0, b, c, t_star + transition_spread * NODES[i], ratio)
        order += SHARES[i] * x * q3
        possible += SHARES[i] * q3
    return order / possible, possible, q0


_SOURCE = "(4.21), Amp 0.2, T_h 30 s"

EQUILIBRIUM = Term(
    name="equilibrium",
    stage="order",
    equation="x = W13/(W13 + W31), W13 = ((Q3-Q2)/a3)^2 exp(-E21/kT), W31 = ((Q2-Q1)/a1)^2 exp(-E23/kT)",
    parameters=(
        Parameter("a0", "J/K", 5.58e-22, 5e-24, 5e-20, "slope A0 of the quadratic coefficient", _SOURCE, "log"),
        Parameter("b", "J", 7.70e-20, 1e-21, 5e-18, "cubic coefficient B", _SOURCE, "log"),
        Parameter("c_r", "J", 7.91e-20, 1e-21, 5e-18, "quartic coefficient C, heating", _SOURCE, "log"),
        Parameter("c_c", "J", 6.76e-20, 1e-21, 5e-18, "quartic coefficient C, cooling", _SOURCE, "log"),
        Parameter("t_star_r", "K", 305.0, 250.0, 400.0, "supercooling temperature T*, heating", _SOURCE),
        Parameter("t_star_c", "K", 291.9, 230.0, 400.0, "supercooling temperature T*, cooling", _SOURCE),
        Parameter("a1_r", "1", 1.68, 0.01, 1000.0, "transition parameter a1, heating", _SOURCE, "log"),
        Parameter("a3_r", "1", 10.60, 0.01, 1000.0, "transition parameter a3, heating", _SOURCE, "log"),
        Parameter("a1_c", "1", 0.93, 0.01, 1000.0, "transition parameter a1, cooling", _SOURCE, "log"),
        Parameter("a3_c", "1", 3.53, 0.01, 1000.0, "transition parameter a3, cooling", _SOURCE, "log"),
        Parameter("q0", "1", 1.0, 0.1, 5.0, "mean order Q̄0 at λ = 1", "§4.6.1: Q̄0 = 1", fixed=True),
    ),
    outputs=("fraction", "well_order", "reference_order"),
    step=step,
)
