# SPDX-License-Identifier: Apache-2.0
"""The camera shows the temperature late: a first-order lag, and a dead time.

τ dy/dt = T - y, and y(t - delay) is shown. The past is kept at GRID times in a delay, and read in between.

In the residual: a sheared T–d loop, while P→d is as it was. thermal_gradient has the opposite sign. A sensor that is
later than 2 s sits on a mass of its own: second_mass, which is the same lag on another scale. Bounds may be widened.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_model.effects import Effect
from lce_model.lag import lag
from lce_model.terms import Parameter

GRID: Final = 50
SLOTS: Final = GRID + 2
SHORTEST_S: Final = 1e-6


def start(measured_temperature: float, past: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """At rest for long."""
    past[:] = measured_temperature
    return 0.0, measured_temperature, measured_temperature, measured_temperature


def step(
    measured_temperature: float,
    dt: float,
    past: NDArray[np.float64],
    clock: float,
    before: float,
    late: float,
    tau: float,
    delay: float,
) -> tuple[float, float, float, float]:
    """Time [s] since the beginning, temperature [K] before the sensor, after the lag, and as shown."""
    after = lag(late, before, measured_temperature, dt, tau)
    now = clock + dt
    if delay < SHORTEST_S:
        return now, measured_temperature, after, after
    # past[k % SLOTS] is y at the time k spacing; what is older than the ring is not asked for.
    spacing = delay / GRID
    first, last = math.floor(clock / spacing) + 1, math.floor(now / spacing)
    for k in range(max(first, last - SLOTS + 1), last + 1):
        past[k % SLOTS] = late + (after - late) * (k * spacing - clock) / dt
    at = (now - delay) / spacing
    k = math.floor(at)
    shown = past[k % SLOTS] + (past[(k + 1) % SLOTS] - past[k % SLOTS]) * (at - k)
    return now, measured_temperature, after, shown


EFFECT = Effect(
    name="camera_lag",
    title="camera lag",
    meaning="the camera shows the temperature late",
    stage="sensor",
    equation="tau dy/dt = T - y, T_meas(t) = y(t - delay)",
    parameters=(
        Parameter("tau", "s", 0.0, 0.0, 2.0, "time constant of the lag τ", "sensor lag dominates public heater data"),
        Parameter("delay", "s", 0.0, 0.0, 0.5, "dead time", "plausible, no source found"),
    ),
    states=("clock", "before", "late"),
    arrays=(("past", SLOTS),),
    outputs=("measured_temperature",),
    start=start,
    step=step,
    strength="tau",
    acting_alone=("delay",),
    typical=0.3,
    step_sizes=(0.05,),
    place=1,
)
