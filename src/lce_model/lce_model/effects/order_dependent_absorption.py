# SPDX-License-Identifier: Apache-2.0
"""The strip absorbs more or less light as its order, hence its shape and its dichroism, changes.

P_L = P (1 + κ (1 - Q̄/Q̄0)), with the order halfway, as the step before lets expect.

In the residual: a step of the gain across the transition that follows d. Like latent_heat, which a hold does not show.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(light: float) -> tuple[float, float]:
    """In the dark; the order is not known yet."""
    return math.nan, light


def step(light: float, order: float, reference_order: float, before: float, kappa: float) -> tuple[float, float]:
    """The order now, and the light [W] that counts; all of it where the model has no order."""
    midway = order if math.isnan(before) else order + 0.5 * (order - before)
    lost = 1.0 - midway / reference_order
    return order, light if math.isnan(lost) else light * (1.0 + kappa * lost)


EFFECT = Effect(
    name="order_dependent_absorption",
    title="absorption that follows the order",
    meaning="the strip absorbs more or less light as its order changes",
    stage="light",
    equation="P_L = P (1 + kappa (1 - Q/Q0))",
    parameters=(
        Parameter(
            "kappa",
            "1",
            0.0,
            -0.6,
            0.6,
            "relative change of the absorption from full to no order",
            "face area ∝ λ^½, computed",
        ),
    ),
    states=("before",),
    outputs=("light",),
    start=start,
    step=step,
    strength="kappa",
    typical=0.1,
)
