# SPDX-License-Identifier: Apache-2.0
"""The distance sensor drifts: d + r t.

In the residual: an offset of d that grows with time, at rest too. residual_strain grows with the cycles.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(measured_displacement: float) -> tuple[float, float]:
    """The clock starts with the run."""
    return 0.0, measured_displacement


def step(measured_displacement: float, dt: float, elapsed: float, rate: float) -> tuple[float, float]:
    """Time [s] since the beginning, and what the sensor shows [m]."""
    elapsed = elapsed + dt
    return elapsed, measured_displacement + rate * elapsed


EFFECT = Effect(
    name="displacement_drift",
    title="drift of the distance sensor",
    meaning="the reading of the distance sensor drifts with time",
    stage="sensor",
    equation="d_meas = d + r t",
    parameters=(Parameter("rate", "m/s", 0.0, -1e-5, 1e-5, "drift r", "plausible, no source found"),),
    states=("elapsed",),
    outputs=("measured_displacement",),
    start=start,
    step=step,
    strength="rate",
    typical=1e-6,
)
