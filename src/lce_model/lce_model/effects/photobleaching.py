# SPDX-License-Identifier: Apache-2.0
"""The dye bleaches with the dose of light and does not recover: dη/dt = -k_b P η.

In the residual: a gain that falls with ∫P dt. Like laser_droop, which recovers.
"""

import math

from lce_model.effects import Effect
from lce_model.terms import Parameter


def start(light: float) -> tuple[float, float]:
    """A fresh dye."""
    return 0.0, light


def step(light: float, dt: float, dose: float, k_b: float) -> tuple[float, float]:
    """Dose [J] and light [W]; half of the step's own dose counts for it."""
    after = dose + light * dt
    return after, light * math.exp(-0.5 * k_b * (dose + after))


EFFECT = Effect(
    name="photobleaching",
    title="photobleaching",
    meaning="the dye bleaches with the dose of light and does not recover",
    stage="light",
    equation="P_L = P exp(-k_b D), dD/dt = P",
    parameters=(Parameter("k_b", "1/J", 0.0, 0.0, 0.01, "bleaching rate per dose k_b", "plausible, no source found"),),
    states=("dose",),
    outputs=("light",),
    start=start,
    step=step,
    strength="k_b",
    typical=1e-3,
)
