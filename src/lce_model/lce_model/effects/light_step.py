# SPDX-License-Identifier: Apache-2.0
"""From a time on the strip absorbs another share of the light: a beam that slipped, a smear on the lens.

P_L = (1 + s) P from t_0 on.

In the residual: from a time on another gain, none with the laser off. photobleaching goes on and on; loss_step changes
the cooling, too.
"""

from lce_model.effects import Effect
from lce_model.lag import share_after
from lce_model.terms import Parameter


def step(light: float, elapsed_time: float, dt: float, change: float, time: float) -> float:
    """Light [W], mean over the step."""
    return light * (1.0 + change * share_after(time, elapsed_time - dt, elapsed_time))


EFFECT = Effect(
    name="light_step",
    title="another absorption from a time on",
    meaning="from a time on the strip absorbs more or less light: a beam that slipped",
    stage="light",
    equation="P_L = (1 + s) P for t > t_0",
    parameters=(
        Parameter("change", "1", 0.0, -1.0, 3.0, "relative change s of the light", "a beam that misses: -1"),
        Parameter("time", "s", 20.0, 0.0, 1e7, "time t_0 since the beginning", "any", scale="asinh", knee=1.0),
    ),
    outputs=("light",),
    step=step,
    strength="change",
    typical=0.2,
    grid=(("time", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)),),
    in_durations=("time",),
)
