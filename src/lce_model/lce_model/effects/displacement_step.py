# SPDX-License-Identifier: Apache-2.0
"""From a time on the reading of the distance sensor is shifted: the sensor or the mount of the strip slipped.

The shift d_0 comes in evenly from t_0 to t_0 + Δ. A real slip takes no time; a Δ lets a fit find the time of it.

In the residual: a jump of d that stays. displacement_drift and residual_strain grow steadily.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(measured_displacement: float, elapsed_time: float, dt: float, shift: float, time: float, over: float) -> float:
    """What the sensor shows [m]."""
    # Over a step at least, so that the time has a derivative.
    come = (elapsed_time - time) / max(over, dt) if elapsed_time > time else 0.0
    return measured_displacement + shift * min(come, 1.0)


EFFECT = Effect(
    name="displacement_step",
    title="shift of the distance reading",
    meaning="from a time on the reading of the distance sensor is shifted: a slip",
    stage="sensor",
    equation="d_meas = d + d_0 min(max((t - t_0)/Delta, 0), 1)",
    parameters=(
        Parameter("shift", "m", 0.0, -5e-3, 5e-3, "shift d_0", "plausible, no source found"),
        Parameter("time", "s", 20.0, 0.0, 1e7, "time t_0 since the beginning", "any", scale="asinh", knee=1.0),
        Parameter("over", "s", 5.0, 0.0, 10.0, "time Δ that the slip takes", "longer, it is a drift", "asinh", 0.1),
    ),
    outputs=("measured_displacement",),
    step=step,
    strength="shift",
    typical=1e-4,
    grid=(("time", tuple(0.025 + 0.05 * i for i in range(20))),),
    in_durations=("time",),
)
