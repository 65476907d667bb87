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
        """Its name in files, which have one for both powers that lag, and one for both paths."""
        return {"late_power": "lagged_power", "displacement_path": "path"}.get(self.name, self.name)


COVARIATES: Final[tuple[Covariate, ...]] = (
    Covariate("temperature", "K", "temperature"),
    Covariate("rate", "K/s", "heating rate"),
    Covariate("power", "W", "laser power"),
    Covariate("order", "1", "order parameter"),
    Covariate("displacement", "m", "displacement"),
    Covariate("time", "s", "time"),
    Covariate("dose", "J", "dose of light"),
    Covariate("path", "K", "path of the temperature"),
    Covariate("branch", "1", "branch"),
    Covariate("cycle", "1", "cycle"),
    Covariate("lagged_temperature", "K", "temperature less what it was before", lagged=True),
    Covariate("lagged_power", "W", "laser power less what it was before", lagged=True),
    Covariate("lagged_displacement", "m", "displacement less what it was before", lagged=True),
    Covariate("late_power", "W", "laser power as it was before", lagged=True),
    Covariate("displacement_path", "m", "path of the displacement"),
)
"""In the order of their numbers. ``path`` is ∫|dT| and ``displacement_path`` ∫|dd|, ``dose`` ∫P dt, ``branch`` +1 while
heating and -1 while cooling; ``cycle`` counts the turns from cooling to heating since the run began. What was before is
a first-order lag."""
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

    What the covariate remembers and the value before (both NaN at the beginning, a step of no time), and the value;
    NaN where the model has no such quantity.
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
    elif covariate == 14.0:
        memory = 0.0 if math.isnan(memory) or math.isnan(before) else memory + abs(displacement - before)
        before = displacement
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
