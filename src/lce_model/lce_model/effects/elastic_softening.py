# SPDX-License-Identifier: Apache-2.0
"""The hot strip is softer and sags under its load: σ/E(T), E = E0 exp(-(T - T0)/T_E), T0 that of the strip at rest.

In the residual: a sag when hot that grows with the load. Like thermal_expansion.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(stretch: float, temperature: float, rest_temperature: float, sag: float, t_e: float) -> float:
    """λ with the sag; that at T0 belongs to the length at rest."""
    return stretch + sag * math.expm1((temperature - rest_temperature) / t_e)


EFFECT = Effect(
    name="elastic_softening",
    title="softening",
    meaning="the hot strip is softer and sags under its load",
    stage="strain",
    equation="lambda -> lambda + sigma/E0 (exp((T - T0)/T_E) - 1)",
    parameters=(
        Parameter("sag", "1", 0.0, 0.0, 0.1, "strain at rest under the load σ/E0", "33 kPa under 5 g, computed"),
        Parameter(
            "t_e",
            "K",
            80.0,
            30.0,
            300.0,
            "temperature over which E falls by e",
            "plausible, no source found",
            scale="log",
        ),
    ),
    outputs=("stretch",),
    step=step,
    strength="sag",
    typical=0.02,
    grid=(("t_e", (40.0, 80.0, 200.0)),),
)
