# SPDX-License-Identifier: Apache-2.0
"""The network expands with the temperature: λ (1 + α_th (T - T_ref)), T_ref that of the strip at rest.

In the residual: a linear slope of d above the transition. Like elastic_softening.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(stretch: float, temperature: float, rest_temperature: float, alpha_th: float) -> float:
    """λ with the expansion; at rest the strip has its length L0."""
    return stretch * (1.0 + alpha_th * (temperature - rest_temperature))


EFFECT = Effect(
    name="thermal_expansion",
    title="thermal expansion",
    meaning="the network expands as it gets hotter",
    stage="strain",
    equation="lambda -> lambda (1 + alpha_th (T - T_ref))",
    parameters=(
        Parameter("alpha_th", "1/K", 0.0, 0.0, 2e-3, "linear expansion coefficient α_th", "plausible, no source found"),
    ),
    outputs=("stretch",),
    step=step,
    strength="alpha_th",
    typical=2e-4,
)
