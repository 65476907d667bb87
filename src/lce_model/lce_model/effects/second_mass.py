# SPDX-License-Identifier: Apache-2.0
"""The sensor sits on a second heat capacity, its board or a holder, that follows the heated body late.

τ_2 dT_2/dt = T - T_2, and T_2 is measured. With the lumped heat balance this is the two-state model

    C_1 dT_1/dt = U_a (T_env - T_1) + U_b (T_2 - T_1) + α P,   C_2 dT_2/dt = U_b (T_1 - T_2)

as far as P and the measured T_2 can show it. Either has two real poles and no zero, so U_a, U_b, C_1, C_2 enter as two
time constants: τ τ_2 = C_1 C_2/(U_a U_b) and τ + τ_2 = C_1/U_a + C_2/U_a + C_2/U_b.

In the residual: T bends slowly after every step of the power, where one time constant starts at full slope. Like
camera_lag, which is the lag of the sensor alone, 2 s at most; clamp_conduction has its second mass beside the strip,
whose own temperature is measured: fast at first, then a slow tail.
"""

from lce_model.effects import Effect
from lce_model.lag import lag
from lce_model.terms import Parameter


def start(measured_temperature: float) -> tuple[float, float, float]:
    """As warm as the heated body."""
    return measured_temperature, measured_temperature, measured_temperature


def step(measured_temperature: float, dt: float, body: float, mass: float, tau: float) -> tuple[float, float, float]:
    """Temperatures of the heated body and of the second mass [K], which is what is measured."""
    mass = lag(mass, body, measured_temperature, dt, tau)
    return measured_temperature, mass, mass


EFFECT = Effect(
    name="second_mass",
    title="second mass",
    meaning="what is measured is a second heat capacity that follows the heated body",
    stage="sensor",
    equation="tau_2 dT_2/dt = T - T_2, T_meas = T_2",
    parameters=(
        Parameter(
            "tau",
            "s",
            0.0,
            0.0,
            2000.0,
            "time constant of the second mass τ_2",
            "16–50 s in public heater data; a body of 1 kg in air: hours",
            scale="asinh",
            knee=5.0,
        ),
    ),
    states=("body", "mass"),
    outputs=("measured_temperature",),
    start=start,
    step=step,
    strength="tau",
    typical=15.0,
    step_sizes=(2.0, 10.0, 50.0, 250.0),
    place=-1,
)
