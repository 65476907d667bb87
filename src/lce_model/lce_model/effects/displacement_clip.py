# SPDX-License-Identifier: Apache-2.0
"""The distance sensor ends: beyond the largest displacement that it can show it shows that one.

d_meas = min(d, 1/k). The strength is k, one over the largest reading, so that none at all is k = 0. It has
no slope there: a fit needs a value to begin with, `--set displacement_clip.inverse=500`.

In the residual: the tops of d are flat, at one and the same value.
"""

from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(measured_displacement: float, inverse: float) -> float:
    """What the sensor shows [m]."""
    return measured_displacement if inverse <= 0.0 else min(measured_displacement, 1.0 / inverse)


EFFECT = Effect(
    name="displacement_clip",
    title="end of the distance sensor",
    meaning="the distance sensor shows nothing beyond its largest displacement",
    stage="sensor",
    equation="d_meas = min(d, 1/k)",
    parameters=(
        Parameter("inverse", "1/m", 0.0, 0.0, 1e4, "one over the largest reading k", "sensors of 10 mm: 100 1/m"),
    ),
    outputs=("measured_displacement",),
    step=step,
    strength="inverse",
    typical=600.0,
    step_sizes=(100.0, 150.0, 220.0, 330.0, 500.0, 700.0, 1000.0),
    place=2,
)
