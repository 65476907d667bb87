# SPDX-License-Identifier: Apache-2.0
"""Light itself breaks the order: bent isomers n lower the transition temperature, T* → T* - β n.

dn/dt = k_p P (1 - n) - n/τ_c. In every model here T enters as T - T*, so the shift is added to the temperature that
the order follows.

In the residual: another d at the same T with the laser on than off. Like thermal_gradient; heating without light tells
them apart.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(order_temperature: float) -> tuple[float, float]:
    """In the dark."""
    return 0.0, order_temperature


def step(
    order_temperature: float, light: float, dt: float, bent: float, beta: float, tau_c: float, k_p: float
) -> tuple[float, float]:
    """Share of bent isomers n, and the temperature [K] that the order follows."""
    rate = k_p * light + 1.0 / tau_c
    steady = k_p * light / rate
    bent = steady + (bent - steady) * math.exp(-rate * dt)
    return bent, order_temperature + beta * bent


EFFECT = Effect(
    name="photochemical_order",
    title="photochemical disorder",
    meaning="light breaks the order directly, besides heating the strip",
    stage="order",
    equation="dn/dt = k_p P (1 - n) - n/tau_c, T* -> T* - beta n",
    parameters=(
        Parameter("beta", "K", 0.0, 0.0, 40.0, "shift of T* when all isomers are bent β", "J. Phys. Chem. B 107, 6039"),
        Parameter(
            "tau_c",
            "s",
            8.0,
            0.5,
            3000.0,
            "life time of the bent isomers τ_c",
            "J. Phys. Chem. B 107, 6039",
            scale="log",
        ),
        Parameter(
            "k_p",
            "1/J",
            0.05,
            1e-4,
            10.0,
            "photo-isomerisation rate per power k_p",
            "plausible, no source found",
            scale="log",
            fixed=True,
        ),
    ),
    states=("bent",),
    outputs=("order_temperature",),
    start=start,
    step=step,
    strength="beta",
    typical=10.0,
    grid=(("tau_c", (1.0, 8.0, 60.0, 500.0)),),
)
