# SPDX-License-Identifier: Apache-2.0
"""The transition takes time: the fraction relaxes towards that of the model, dx/dt = (x_model - x)/τ_x.

In the residual: a loop whose width grows with dT/dt and vanishes when driven slowly. Like thermal_gradient and creep.
"""

from lce_model.effects import Effect
from lce_model.lag import lag
from lce_model.terms import Parameter


def start(fraction: float) -> tuple[float, float, float]:
    """At the fraction of the model."""
    return fraction, fraction, fraction


def step(fraction: float, dt: float, before: float, late: float, tau_x: float) -> tuple[float, float, float]:
    """The fraction of the model, and the one that lags it."""
    late = lag(late, before, fraction, dt, tau_x)
    return fraction, late, late


EFFECT = Effect(
    name="phase_kinetics",
    title="slow transition",
    meaning="the phase transition takes time",
    stage="order",
    equation="tau_x dx/dt = x_model - x",
    parameters=(
        Parameter(
            "tau_x", "s", 0.0, 0.0, 100.0, "relaxation time τ_x", "plausible, no source found", scale="asinh", knee=1.0
        ),
    ),
    states=("before", "late"),
    outputs=("fraction",),
    start=start,
    step=step,
    strength="tau_x",
    typical=1.0,
    step_sizes=(0.05,),
)
