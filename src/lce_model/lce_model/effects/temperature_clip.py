# SPDX-License-Identifier: Apache-2.0
"""The camera ends: beyond the highest temperature of its range it shows that one.

T_meas = min(T, 0 °C + 1/k). The strength is k, one over the highest reading in °C, so that none at all is k = 0. It has
no slope there: a fit needs a value to begin with, `--set temperature_clip.inverse=0.01`.

In the residual: the tops of T are flat, at one and the same value. laser_saturation bends them smoothly.
"""

from lce_data.units import KELVIN
from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(measured_temperature: float, inverse: float) -> float:
    """What the camera shows [K]."""
    return measured_temperature if inverse <= 0.0 else min(measured_temperature, KELVIN + 1.0 / inverse)


EFFECT = Effect(
    name="temperature_clip",
    title="end of the camera's range",
    meaning="the camera shows nothing beyond the highest temperature of its range",
    stage="sensor",
    equation="T_meas = min(T, 273.15 K + 1/k)",
    parameters=(
        Parameter(
            "inverse", "1/K", 0.0, 0.0, 0.05, "one over the highest reading in °C, k", "ranges of 60, 100, 150 °C"
        ),
    ),
    outputs=("measured_temperature",),
    step=step,
    strength="inverse",
    typical=0.02,
    step_sizes=(0.002, 0.004, 0.006, 0.008, 0.010, 0.0125, 0.016, 0.022),
    place=2,
)
