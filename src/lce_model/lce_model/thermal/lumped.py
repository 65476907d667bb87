# SPDX-License-Identifier: Apache-2.0
"""Lumped heat balance of the strip: one temperature, constant loss."""

import math

from lce_model.terms import Parameter, Term


def start(temperature: float, tau: float) -> tuple[float, float]:
    """At the temperature given."""
    return temperature, 1.0 / tau


def step(
    light: float,
    ambient: float,
    heating: float,
    heat_capacity: float,
    temperature: float,
    dt: float,
    gain: float,
    tau: float,
) -> tuple[float, float]:
    """Exact solution over a step with constant light: T relaxes to T_env + K·P (+ τ·heating) with τ."""
    steady = ambient + gain * light + tau * heating
    return steady + (temperature - steady) * math.exp(-dt / (tau * heat_capacity)), 1.0 / tau


LUMPED = Term(
    name="lumped",
    stage="heat",
    equation="tau dT/dt = K P - (T - T_env)",
    parameters=(
        Parameter(
            "gain",
            "K/W",
            30.0,
            1e-4,
            1e6,
            "steady temperature rise per laser power K",
            "absorbed share / (h A), h A = 1.1–2.1 mW/K for a 10 × 5 × 0.3 mm strip",
            scale="log",
            usual=(0.1, 2000.0),
        ),
        Parameter(
            "tau",
            "s",
            18.0,
            0.01,
            1e6,
            "thermal time constant τ = m c / (h A)",
            "m c = 0.030 J/K: 14–28 s",
            scale="log",
            usual=(0.1, 2000.0),
        ),
    ),
    outputs=("temperature", "loss_rate"),
    start=start,
    step=step,
)
