# SPDX-License-Identifier: Apache-2.0
"""The transition takes heat: the heat capacity is c + L g(T) with a bell g around the transition.

g(T) = exp(-((T - T_c)/w)²/2)/(w √(2π)), whose area is 1: L is the heat of the whole transition.

In the residual: a kink at the transition, ∝ dT/dt, none in steady state. Like order_dependent_absorption; slow against
fast ramps tell them apart.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(
    heat_capacity: float, temperature_midway: float, heat: float, center: float, width: float, capacity: float
) -> float:
    """Heat capacity in units of c."""
    z = (temperature_midway - center) / width
    return heat_capacity + heat / capacity * math.exp(-0.5 * z * z) / (width * math.sqrt(2.0 * math.pi))


EFFECT = Effect(
    name="latent_heat",
    title="latent heat",
    meaning="the phase transition takes up heat",
    stage="heat",
    equation="dT/dt = (...) c/(c + L g(T))",
    parameters=(
        Parameter("heat", "J/g", 0.0, 0.0, 10.0, "latent heat L", "0.2–5 J/g in analogues (PRE 78, 011708)"),
        Parameter(
            "center", "K", 320.0, 280.0, 400.0, "temperature of the transition T_c", "within the range of the strip"
        ),
        Parameter("width", "K", 8.0, 2.0, 20.0, "width of the transition w", "plausible, no source found", scale="log"),
        Parameter("capacity", "J/(g K)", 1.8, 0.5, 5.0, "specific heat capacity c", "polymer network", fixed=True),
    ),
    outputs=("heat_capacity",),
    step=step,
    strength="heat",
    typical=2.0,
    grid=(("center", (305.0, 315.0, 325.0, 340.0, 360.0)), ("width", (4.0, 10.0))),
)
