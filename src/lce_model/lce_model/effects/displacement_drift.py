# SPDX-License-Identifier: Apache-2.0
"""The distance sensor drifts: d + r t.

In the residual: an offset of d that grows with time, at rest too. residual_strain grows with the cycles.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(measured_displacement: float, elapsed_time: float, rate: float) -> float:
    """What the sensor shows [m]."""
    return measured_displacement + rate * elapsed_time


EFFECT = Effect(
    name="displacement_drift",
    title="drift of the distance sensor",
    meaning="the reading of the distance sensor drifts with time",
    stage="sensor",
    equation="d_meas = d + r t",
    parameters=(Parameter("rate", "m/s", 0.0, -1e-5, 1e-5, "drift r", "plausible, no source found"),),
    outputs=("measured_displacement",),
    step=step,
    strength="rate",
    typical=1e-6,
)
