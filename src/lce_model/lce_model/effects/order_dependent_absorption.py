# SPDX-License-Identifier: Apache-2.0
"""The strip absorbs more or less light as its order, hence its shape and its dichroism, changes.

η = 1 + κ (1 - Q̄/Q̄0), with the order at the end of the step before.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(light: float) -> float:
    """Unchanged at full order."""
    return light


def step(light: float, order: float, reference_order: float, kappa: float) -> float:
    """Light [W] that counts."""
    return light * (1.0 + kappa * (1.0 - order / reference_order))


EFFECT = Effect(
    name="order_dependent_absorption",
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
    outputs=("light",),
    start=start,
    step=step,
    strength="kappa",
    typical=0.1,
)
