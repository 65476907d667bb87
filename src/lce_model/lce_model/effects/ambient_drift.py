# SPDX-License-Identifier: Apache-2.0
"""The surroundings warm up or cool down: T_env(t) = T_env + r t.

In the residual: an offset of T that grows with time, with the laser off too. displacement_drift shows in d alone.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(ambient: float, elapsed_time: float, dt: float, rate: float) -> float:
    """Ambient temperature [K], in the middle of the step."""
    return ambient + rate * (elapsed_time - 0.5 * dt)


EFFECT = Effect(
    name="ambient_drift",
    title="ambient drift",
    meaning="the surroundings warm up or cool down during the run",
    stage="surroundings",
    equation="T_env(t) = T_env + r t",
    parameters=(
        Parameter("rate", "K/s", 0.0, -0.05, 0.05, "drift r", "replicates of public heater data differ by 3 K"),
    ),
    outputs=("ambient",),
    step=step,
    strength="rate",
    typical=0.01,
)
