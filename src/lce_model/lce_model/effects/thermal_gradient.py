# SPDX-License-Identifier: Apache-2.0
"""The bulk, whose temperature the order follows, lags the surface that the camera sees.

dT_b/dt = (T - T_b)/τ_d, the first mode of the diffusion through the thickness, τ_d = t²/(π² α).

In the residual: a T–d loop that opens with dT/dt. Like phase_kinetics; camera_lag has the opposite sign.
"""

from lce_model.effects import Effect
from lce_model.lag import lag
from lce_model.terms import Parameter


def start(order_temperature: float) -> tuple[float, float, float]:
    """Uniform."""
    return order_temperature, order_temperature, order_temperature


def step(order_temperature: float, dt: float, surface: float, bulk: float, tau_d: float) -> tuple[float, float, float]:
    """Temperatures of the surface and of the bulk [K], which is what the order follows."""
    bulk = lag(bulk, surface, order_temperature, dt, tau_d)
    return order_temperature, bulk, bulk


EFFECT = Effect(
    name="thermal_gradient",
    title="temperature difference across the strip",
    meaning="the bulk is late after the surface that the camera sees",
    stage="order",
    equation="tau_d dT_b/dt = T - T_b",
    parameters=(
        Parameter("tau_d", "s", 0.0, 0.0, 4.0, "diffusion time τ_d", "t²/(π² α) = 0.09 s for 0.3 mm, computed"),
    ),
    states=("surface", "bulk"),
    outputs=("order_temperature",),
    start=start,
    step=step,
    strength="tau_d",
    typical=0.5,
    place=-1,
    step_sizes=(0.05,),
)
