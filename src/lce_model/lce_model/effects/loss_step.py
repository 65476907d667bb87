# SPDX-License-Identifier: Apache-2.0
"""From a time on the heat loss is another: a lid that was opened, a fan that was switched on.

The loss is (1 + s) times that of the heat balance from t_0 on.

In the residual: from a time on both another steady T and another time constant. light_step changes the steady T alone.
"""

from lce_model.effects import Effect
from lce_model.lag import share_after
from lce_model.terms import Parameter


def step(
    heating: float,
    temperature_midway: float,
    ambient: float,
    loss_rate: float,
    elapsed_time: float,
    dt: float,
    change: float,
    time: float,
) -> float:
    """Heating rate [K/s]."""
    extra = change * share_after(time, elapsed_time - dt, elapsed_time)
    return heating - extra * loss_rate * (temperature_midway - ambient)


EFFECT = Effect(
    name="loss_step",
    title="another heat loss from a time on",
    meaning="from a time on the heat loss is another: a lid, a fan",
    stage="heat",
    equation="dT/dt = ... - s (T - T_env)/tau for t > t_0",
    parameters=(
        Parameter("change", "1", 0.0, -0.9, 9.0, "relative change s of the heat loss", "a lid opened: 1.4"),
        Parameter("time", "s", 20.0, 0.0, 1e7, "time t_0 since the beginning", "any", scale="asinh", knee=1.0),
    ),
    outputs=("heating",),
    step=step,
    strength="change",
    typical=0.3,
    grid=(("time", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)),),
    in_durations=("time",),
)
