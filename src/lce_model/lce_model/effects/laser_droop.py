# SPDX-License-Identifier: Apache-2.0
"""The laser warms up and gives less while it is on; off, it recovers.

P_L = P (1 - δ s), where s goes to 1 while the laser is on and to 0 while it is off, with the time constant τ.

In the residual: T falls during a hold and is back after time off. Like clamp_conduction and photobleaching, until the
run is repeated after a rest.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(light: float) -> tuple[float, float]:
    """Cold."""
    return 0.0, light


def step(light: float, dt: float, warmth: float, delta: float, tau: float) -> tuple[float, float]:
    """Warmth s and light [W]."""
    on = 1.0 if light > 0.0 else 0.0
    after = on + (warmth - on) * math.exp(-dt / tau)
    return after, light * (1.0 - delta * 0.5 * (warmth + after))


EFFECT = Effect(
    name="laser_droop",
    title="laser droop",
    meaning="the laser warms up and gives less power while it is on",
    stage="light",
    equation="P_L = P (1 - delta s), tau ds/dt = on - s",
    parameters=(
        Parameter(
            "delta", "1", 0.0, 0.0, 0.2, "share of the power that is lost in the end", "plausible, no source found"
        ),
        Parameter("tau", "s", 60.0, 5.0, 1800.0, "time constant", "plausible, no source found", scale="log"),
    ),
    states=("warmth",),
    outputs=("light",),
    start=start,
    step=step,
    strength="delta",
    typical=0.05,
    grid=(("tau", (15.0, 60.0, 240.0)),),
)
