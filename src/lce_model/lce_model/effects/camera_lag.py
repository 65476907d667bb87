# SPDX-License-Identifier: Apache-2.0
"""The camera shows the temperature late: a first-order lag, and a second one in place of a dead time."""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(measured_temperature: float) -> tuple[float, float, float]:
    """At rest."""
    return measured_temperature, measured_temperature, measured_temperature


def step(
    measured_temperature: float, dt: float, first: float, second: float, tau: float, delay: float
) -> tuple[float, float, float]:
    """Both lags [K]; the second is what is shown."""
    keep = math.exp(-dt / tau) if tau > 0.0 else 0.0
    first = measured_temperature + (first - measured_temperature) * keep
    keep = math.exp(-dt / delay) if delay > 0.0 else 0.0
    second = first + (second - first) * keep
    return first, second, second


EFFECT = Effect(
    name="camera_lag",
    stage="sensor",
    equation="tau dy/dt = T - y; delay dz/dt = y - z",
    parameters=(
        Parameter("tau", "s", 0.0, 0.0, 2.0, "time constant of the lag τ", "sensor lag dominates public heater data"),
        Parameter("delay", "s", 0.0, 0.0, 0.5, "dead time, as a second lag", "plausible, no source found"),
    ),
    states=(
        "first",
        "second",
    ),
    outputs=("measured_temperature",),
    start=start,
    step=step,
    strength="tau",
    typical=0.3,
    nudges=(0.05,),
)
