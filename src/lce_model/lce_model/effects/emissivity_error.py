# SPDX-License-Identifier: Apache-2.0
"""The camera assumes another emissivity: T_meas - T_env = (1 - e)(T - T_env).

In the residual: hardly anything, because the gain and T* take its place; a fit reports it as not determined.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(measured_temperature: float, ambient: float, error: float) -> float:
    """What the camera shows [K]."""
    return measured_temperature - error * (measured_temperature - ambient)


EFFECT = Effect(
    name="emissivity_error",
    title="emissivity error",
    meaning="the camera assumes another emissivity than the strip has",
    stage="sensor",
    equation="T_meas = T - e (T - T_env)",
    parameters=(Parameter("error", "1", 0.0, -0.1, 0.1, "relative error e of the emissivity", "±2 % camera accuracy"),),
    outputs=("measured_temperature",),
    step=step,
    strength="error",
    typical=0.05,
)
