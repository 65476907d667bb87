# SPDX-License-Identifier: Apache-2.0
"""A share of the contraction arrives late: dε_c/dt = (ε - ε_c)/τ_v.

In the residual: d drifts at constant T. Like phase_kinetics and clamp_conduction.
"""

from lce_model.effects import Effect
from lce_model.lag import lag
from lce_model.terms import Parameter


def start(displacement: float) -> tuple[float, float, float]:
    """Relaxed."""
    return displacement, displacement, displacement


def step(
    displacement: float, dt: float, before: float, late: float, share: float, tau_v: float
) -> tuple[float, float, float]:
    """Displacement without creep, what is late of it, and the displacement [m]."""
    late = lag(late, before, displacement, dt, tau_v)
    return displacement, late, displacement + share * (late - displacement)


EFFECT = Effect(
    name="creep",
    title="creep",
    meaning="part of the contraction arrives late",
    stage="strain",
    equation="d -> (1 - share) d + share d_c, tau_v dd_c/dt = d - d_c",
    parameters=(
        Parameter("share", "1", 0.0, 0.0, 0.5, "share that arrives late", "d3sm00770g; adfm.202311425"),
        Parameter("tau_v", "s", 10.0, 0.1, 1000.0, "retardation time τ_v", "d3sm00770g; adfm.202311425", scale="log"),
    ),
    states=("before", "late"),
    outputs=("displacement",),
    start=start,
    step=step,
    strength="share",
    typical=0.1,
    grid=(("tau_v", (1.0, 5.0, 25.0, 125.0)),),
)
