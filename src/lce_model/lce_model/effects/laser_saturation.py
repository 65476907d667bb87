# SPDX-License-Identifier: Apache-2.0
"""The laser gives less than it is asked for at high power, and nothing below a threshold.

P_L = P_s (1 - exp(-max(P - P_th, 0)/P_s)), written with the curvature 1/P_s, which is 0 for a linear laser.

In the residual: a curved steady T(P), while the cooling fits well, which radiation and natural_convection spoil.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(light: float, curvature: float, p_th: float) -> float:
    """Light [W] of the power asked for [W]."""
    above = max(light - p_th, 0.0)
    if curvature == 0.0:
        return above
    return -math.expm1(-curvature * above) / curvature


EFFECT = Effect(
    name="laser_saturation",
    title="laser saturation",
    meaning="the laser gives less than it is asked for: at high power, or below a threshold",
    stage="light",
    equation="P_L = (1 - exp(-c max(P - P_th, 0)))/c, c = 1/P_s",
    parameters=(
        Parameter("curvature", "1/W", 0.0, 0.0, 1.0, "curvature 1/P_s", "plausible, no source found; P_s 1–50 W"),
        Parameter("p_th", "W", 0.0, 0.0, 0.5, "threshold P_th", "plausible, no source found"),
    ),
    outputs=("light",),
    step=step,
    strength="curvature",
    acting_alone=("p_th",),
    typical=0.1,
    place=-1,
)
