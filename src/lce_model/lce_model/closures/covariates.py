# SPDX-License-Identifier: Apache-2.0
"""What an unknown function may depend on: the covariates, each followed along a simulation.

A covariate is a number, so that one compiled model serves them all.
"""

import math
from dataclasses import dataclass
from typing import Final

from numba.extending import register_jitable

from lce_model.lag import lag


@dataclass(frozen=True)
class Covariate:
    """A quantity of the strip that an unknown function may depend on.

    words : what people call it; lagged : has it the time constant of a lag?
    """

    name: str
    unit: str
    words: str
    lagged: bool = False

    @property
    def published(self) -> str:
        """Its name in files: a lagged power is one, whether the power itself is taken off or not."""
        return "lagged_power" if self.name == "late_power" else self.name


COVARIATES: Final[tuple[Covariate, ...]] = (
    Covariate("temperature", "K", "the temperature"),
    Covariate("rate", "K/s", "the heating rate"),
    Covariate("power", "W", "the laser power"),
    Covariate("order", "1", "the order parameter"),
    Covariate("displacement", "m", "the displacement"),
    Covariate("time", "s", "the time"),
    Covariate("dose", "J", "the energy of the laser so far"),
    Covariate("path", "K", "the path of the temperature so far"),
    Covariate("branch", "1", "the branch, +1 heating and -1 cooling"),
    Covariate("cycle", "1", "the cycle"),
    Covariate("lagged_temperature", "K", "the temperature less what it was before", lagged=True),
    Covariate("lagged_power", "W", "the laser power less what it was before", lagged=True),
    Covariate("lagged_displacement", "m", "the displacement less what it was before", lagged=True),
    Covariate("late_power", "W", "what the laser power was before", lagged=True),
)
"""In the order of their numbers."""
NUMBER: Final[dict[str, int]] = {covariate.name: i for i, covariate in enumerate(COVARIATES)}


@register_jitable
def follow(
    covariate: float,
    tau: float,
    temperature: float,
    warming: float,
    power: float,
    order: float,
    displacement: float,
    direction: float,
    dt: float,
    elapsed_time: float,
    memory: float,
    before: float,
) -> tuple[float, float, float]:
    """Advance a covariate by a step.

    What the covariate remembers and the value before (both NaN at the beginning), and the value; NaN where the model
    has no such quantity.
    """
    value = math.nan
    heating = warming if math.isnan(direction) else direction
    if covariate == 0.0:
        value = temperature
    elif covariate == 1.0:
        value = 0.0 if math.isnan(warming) else warming
    elif covariate == 2.0:
        value = power
    elif covariate == 3.0:
        value = order
    elif covariate == 4.0:
        value = displacement
    elif covariate == 5.0:
        value = elapsed_time
    elif covariate == 6.0:
        memory = 0.0 if math.isnan(memory) else memory + power * dt
        value = memory
    elif covariate == 7.0:
        memory = 0.0 if math.isnan(memory) else memory + abs(temperature - before)
        before = temperature
        value = memory
    elif covariate == 8.0:
        value = -1.0 if heating < 0.0 else 1.0
    elif covariate == 9.0:
        memory = 0.0 if math.isnan(memory) else memory
        if heating > 0.0 and before < 0.0:
            memory = memory + 1.0
        if heating != 0.0:
            before = heating
        value = memory
    else:
        now = temperature if covariate == 10.0 else displacement
        if covariate == 11.0 or covariate == 13.0:
            # The power is held over the step.
            now = before = power
        memory = now if math.isnan(memory) else lag(memory, before, now, dt, tau)
        before = now
        value = memory if covariate == 13.0 else now - memory
    return memory, before, value
