# SPDX-License-Identifier: Apache-2.0
"""Natural convection: the loss grows with the excess temperature, as (ΔT/40 K)^¼, instead of being constant.

share of the loss follows that law; the whole loss is that of the heat balance at ΔT = 40 K.

In the residual: as radiation, but stronger near ambient.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(heating: float, temperature_midway: float, ambient: float, loss_rate: float, share: float) -> float:
    """Heating rate [K/s]."""
    excess = temperature_midway - ambient
    return heating - share * loss_rate * excess * (math.sqrt(math.sqrt(abs(excess) / 40.0)) - 1.0)


EFFECT = Effect(
    name="natural_convection",
    title="natural convection",
    meaning="the hotter the strip, the more heat it loses per kelvin",
    stage="heat",
    equation="dT/dt = ... - share (T - T_env)/tau ((|T - T_env|/40 K)^(1/4) - 1)",
    parameters=(
        Parameter(
            "share",
            "1",
            0.0,
            0.0,
            1.0,
            "share of the loss that is natural convection",
            "h = 7.5/10.6/12.7 W/(m² K) at ΔT = 10/40/80 K, computed",
        ),
    ),
    outputs=("heating",),
    step=step,
    strength="share",
    typical=0.5,
)
