# SPDX-License-Identifier: Apache-2.0
"""The transition takes heat: the heat capacity is c + L g(p) - L_x dx/dT.

L_x is taken as the share x of nematic molecules falls, as the deformation model has it in the step before. L is for
where that is not known, without a deformation model or beside a wrong one: it is taken over a bell g around the
transition.

g(p) = exp(-((p - T_c)/w)²/2)/(w √(2π)), whose area is 1: L is the heat of the whole transition. p follows T with a play
of r on either side, as the order does that takes the heat: the transition lies at T_c + r when the strip warms, and at
T_c - r when it cools. While p stands still, the heat capacity is c.

In the residual: a kink at the transition, ∝ dT/dt, none in steady state. Like order_dependent_absorption; slow against
fast ramps tell them apart.
"""

import math
from typing import Final

from lce_model.effects import Effect
from lce_model.terms import Parameter

LEAST_K: Final = 1e-12
"""A change of the temperature in a step that is smaller than this counts as this [K]."""


def start(heat_capacity: float, temperature: float, hysteresis: float) -> tuple[float, float, float, float]:
    """Cooled down to this temperature; x is not known yet."""
    return temperature + hysteresis, math.nan, temperature, heat_capacity


def step(
    heat_capacity: float,
    temperature_before: float,
    warming: float,
    dt: float,
    fraction: float,
    play: float,
    nematic: float,
    cooler: float,
    heat: float,
    order_heat: float,
    center: float,
    width: float,
    hysteresis: float,
    capacity: float,
) -> tuple[float, float, float, float]:
    """Temperature that the transition is at when the step begins [K], x and T then, heat capacity in units of c."""
    play = min(max(play, temperature_before - hysteresis), temperature_before + hysteresis)
    change = dt * warming
    after = min(max(play, temperature_before + change - hysteresis), temperature_before + change + hysteresis)
    # p may begin to move within the step: with its share of the step, the simulation has a derivative by r.
    share = min(abs(after - play) / max(abs(change), LEAST_K), 1.0) if hysteresis > 0.0 else 1.0
    z = (0.5 * (play + after) - center) / width
    bell = share * math.exp(-0.5 * z * z) / (width * math.sqrt(2.0 * math.pi))
    warmer = temperature_before - cooler
    turned = nematic - fraction if abs(warmer) > LEAST_K else math.nan
    slope = max(turned / warmer, 0.0) if not math.isnan(turned) else 0.0
    taken = heat * bell + order_heat * slope
    return play, fraction, temperature_before, heat_capacity + taken / capacity


EFFECT = Effect(
    name="latent_heat",
    title="latent heat",
    meaning="the phase transition takes up heat",
    stage="heat",
    equation="dT/dt = (...) c/(c + L g(p) - L_x dx/dT), p = min(max(p, T - r), T + r)",
    parameters=(
        Parameter(
            "heat", "J/g", 0.0, 0.0, 10.0, "latent heat L over the bell", "0.2–5 J/g in analogues (PRE 78, 011708)"
        ),
        Parameter("order_heat", "J/g", 0.0, 0.0, 20.0, "latent heat L_x as the order falls", "as L"),
        Parameter(
            "center", "K", 320.0, 280.0, 400.0, "temperature of the transition T_c", "within the range of the strip"
        ),
        Parameter("width", "K", 8.0, 2.0, 20.0, "width of the transition w", "plausible, no source found", scale="log"),
        Parameter(
            "hysteresis",
            "K",
            0.0,
            0.0,
            20.0,
            "half-width of its hysteresis r",
            "5 K: the boundaries (4.22) lie 10 K higher in warming",
        ),
        Parameter("capacity", "J/(g K)", 1.8, 0.5, 5.0, "specific heat capacity c", "polymer network", fixed=True),
    ),
    states=("play", "nematic", "cooler"),
    outputs=("heat_capacity",),
    start=start,
    step=step,
    strength="heat",
    acting_alone=("order_heat",),
    typical=2.0,
    grid=(("center", (305.0, 315.0, 325.0, 340.0, 360.0)), ("width", (4.0, 10.0)), ("hysteresis", (0.0, 6.0))),
)
