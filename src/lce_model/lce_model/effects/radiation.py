# SPDX-License-Identifier: Apache-2.0
"""The strip radiates: a loss ∝ T⁴ - T_env⁴ beside that of the heat balance.

In the residual: a cooling that is faster at high T. Like natural_convection, nearly alike from 28 to 90 °C; a wider
range tells them apart.
"""

from lce_model.constants import STEFAN_BOLTZMANN
from lce_model.effects import Effect
from lce_model.terms import Parameter


def step(
    heating: float, temperature_midway: float, ambient: float, emissivity: float, area_per_capacity: float
) -> float:
    """Heating rate [K/s]."""
    return heating - emissivity * STEFAN_BOLTZMANN * area_per_capacity * (temperature_midway**4 - ambient**4)


EFFECT = Effect(
    name="radiation",
    title="thermal radiation",
    meaning="the strip loses heat with the fourth power of its temperature",
    stage="heat",
    equation="dT/dt = ... - eps sigma (A/mc) (T^4 - T_env^4)",
    parameters=(
        Parameter(
            "emissivity", "1", 0.0, 0.0, 1.0, "emissivity ε", "h_rad = 5.9–12.1 W/(m² K) over 28–110 °C, computed"
        ),
        Parameter(
            "area_per_capacity",
            "m^2 K/J",
            3.6e-3,
            1e-4,
            0.1,
            "surface per heat capacity A/(m c)",
            "1.09e-4 m² and 0.030 J/K for a 10 × 5 × 0.3 mm strip",
            fixed=True,
        ),
    ),
    outputs=("heating",),
    step=step,
    strength="emissivity",
    typical=0.5,
)
