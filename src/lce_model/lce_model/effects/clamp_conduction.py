# SPDX-License-Identifier: Apache-2.0
"""The clamps, and the ends of the strip that they hold, take up heat, warm up, and give it back: a second, slow node.

dT/dt = … - G/(m c) (T - T_c), τ_c dT_c/dt = s (T - T_env) - (T_c - T_env), with s = G/(G + G_a).

A clamp follows within minutes. The cold end of the strip itself follows within seconds: heat comes through a millimetre
of elastomer in l²/α = 10 s.

In the residual: a tail of two exponentials after a step. Like laser_droop; creep shows in d alone.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(heating: float, ambient: float) -> tuple[float, float]:
    """The clamp as warm as its surroundings."""
    return ambient, heating


def step(
    heating: float,
    temperature_midway: float,
    ambient: float,
    dt: float,
    clamp: float,
    conductance: float,
    tau: float,
    capacity: float,
    share: float,
) -> tuple[float, float]:
    """Temperature of the clamp [K] and heating rate [K/s]."""
    goal = ambient + share * (temperature_midway - ambient)
    after = goal + (clamp - goal) * math.exp(-dt / tau)
    return after, heating - conductance / capacity * (temperature_midway - 0.5 * (clamp + after))


EFFECT = Effect(
    name="clamp_conduction",
    title="heat into the clamps",
    meaning="the clamps take up heat, warm up and give it back",
    stage="heat",
    equation="dT/dt = ... - G/mc (T - T_c), tau_c dT_c/dt = s (T - T_env) - (T_c - T_env)",
    parameters=(
        Parameter(
            "conductance", "W/K", 0.0, 0.0, 2e-3, "conductance strip to clamp G", "k A/L = 0.06–0.2 mW/K, computed"
        ),
        Parameter(
            "tau",
            "s",
            200.0,
            1.0,
            2000.0,
            "time constant of the clamp τ_c, or of the end of the strip in it",
            "end of the strip: l²/α = 10 s for 1 mm, computed; clamp: plausible, no source found",
            scale="log",
            usual=(20.0, 2000.0),
        ),
        Parameter(
            "capacity",
            "J/K",
            0.030,
            1e-3,
            1.0,
            "heat capacity of the strip m c",
            "10 × 5 × 0.3 mm, 1100 kg/m³, 1.8 J/(g K)",
            fixed=True,
        ),
        Parameter(
            "share",
            "1",
            0.5,
            0.05,
            0.95,
            "share s of the strip in what the clamp follows",
            "plausible, no source found",
            fixed=True,
        ),
    ),
    states=("clamp",),
    outputs=("heating",),
    start=start,
    step=step,
    strength="conductance",
    typical=1e-4,
    grid=(("tau", (6.0, 30.0, 100.0, 400.0)),),
)
