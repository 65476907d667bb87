# SPDX-License-Identifier: Apache-2.0
"""A load favours the long, ordered phase: T* → T* + c (F - F_ref), after Clausius and Clapeyron.

c = dT/dF = ε T/(ρ L A), with the strain ε and the latent heat L of the transition and the cross-section A. In every
model here T enters as T - T*, so the shift is taken from the temperature that the order follows. A negative shift says
that the load was recorded with the other sign. Where the load is not known, it is F_ref.

In the residual: a transition at another T under another load. load_stretch shifts d by the same at every T.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(order_temperature: float, load: float, shift: float, f_ref: float) -> float:
    """Temperature [K] that the order follows, at least 1 K."""
    return order_temperature if math.isnan(load) else max(order_temperature - shift * (load - f_ref), 1.0)


EFFECT = Effect(
    name="load_shift",
    title="transition shifted by the load",
    meaning="a load raises the temperature of the transition",
    stage="order",
    equation="T* -> T* + c (F - F_ref)",
    parameters=(
        Parameter(
            "shift",
            "K/N",
            0.0,
            -500.0,
            500.0,
            "shift of the transition per load c",
            "ε T/(ρ L A): strip 16–400 K/N, NiTi wire of 0.25 mm 2 K/N, computed; cond-mat/0111173",
            scale="asinh",
            knee=0.1,
        ),
        Parameter("f_ref", "N", 0.0, -100.0, 100.0, "load F_ref at which T* holds", "no load", fixed=True),
    ),
    outputs=("order_temperature",),
    step=step,
    strength="shift",
    typical=40.0,
    step_sizes=(0.01,),
)
