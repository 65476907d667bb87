# SPDX-License-Identifier: Apache-2.0
"""An unknown function f(z) of one covariate is added to the heat balance."""

import math

from lce_model.closures.covariates import follow
from lce_model.closures.forms import KNOTS, Floats, value
from lce_model.closures.place import parameters
from lce_model.effects import Effect


def step(
    heating: float,
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
    strength: float,
    covariate: float,
    tau: float,
    form: float,
    lower: float,
    upper: float,
    z0: float,
    a: float,
    b: float,
    w: Floats,
) -> tuple[float, float, float]:
    """Memory of the covariate and its value before, and the heating rate [K/s]."""
    # In the middle of the step that comes, as the balance is solved over it.
    warm = temperature if math.isnan(warming) else temperature + 0.5 * dt * warming
    memory, before, z = follow(
        covariate, tau, warm, warming, power, order, displacement, direction, dt, elapsed_time, memory, before
    )
    return memory, before, heating + strength * value(form, z, z0, a, b, lower, upper, w)


EFFECT = Effect(
    name="closure_heat",
    title="unknown function in the heat balance",
    meaning="an unknown function of one covariate acts on the heat balance",
    stage="heat",
    equation="dT/dt -> dT/dt + f(z)",
    parameters=parameters("K/s", 0.001),
    states=("memory", "before"),
    outputs=("heating",),
    vectors=(("w", KNOTS),),
    start=step,
    step=step,
    strength="strength",
    typical=1.0,
    step_sizes=(1.0,),
)
