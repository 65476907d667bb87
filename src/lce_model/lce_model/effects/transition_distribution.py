# SPDX-License-Identifier: Apache-2.0
"""The transition temperatures of the domains are spread: T*_i = T* + σ_T z_i, z normally distributed.

Each domain follows the model with its own T*, and with its own memory where the model has one; the order is the mean
of theirs. Rounded knees, and minor loops that close within the major one.

In the residual: rounded knees, and minor loops. Like phase_kinetics, which depends on the rate.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(transition_spread: float, sigma_t: float) -> float:
    """Standard deviation of T* [K]; another spread adds to it as independent causes do."""
    return math.hypot(transition_spread, sigma_t)


EFFECT = Effect(
    name="transition_distribution",
    title="spread of the transition",
    meaning="the domains change phase at different temperatures",
    stage="order",
    equation="Q = mean_i Q(T; T* + sigma_T z_i), z_i ~ N(0, 1)",
    parameters=(
        Parameter(
            "sigma_t", "K", 0.0, 0.0, 20.0, "standard deviation of T*, σ_T", "quenched disorder (cond-mat/0111173)"
        ),
    ),
    outputs=("transition_spread",),
    step=step,
    strength="sigma_t",
    typical=4.0,
    step_sizes=(2.0, 6.0),
)
