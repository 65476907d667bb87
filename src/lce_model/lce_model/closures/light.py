# SPDX-License-Identifier: Apache-2.0
"""The light that reaches the strip is multiplied by 1 + f(z), an unknown function of one covariate."""

import math

from lce_model.closures.covariates import follow
from lce_model.closures.forms import KNOTS, Floats, value
from lce_model.closures.place import parameters
from lce_model.effects import Effect


def step(
    light: float,
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
    """Memory of the covariate and its value before, and the light [W]."""
    # In the middle of the step that comes, as the balance is solved over it.
    warm = temperature if math.isnan(warming) else temperature + 0.5 * dt * warming
    memory, before, z = follow(
        covariate, tau, warm, warming, power, order, displacement, direction, dt, elapsed_time, memory, before
    )
    return memory, before, light * (1.0 + strength * value(form, z, z0, a, b, lower, upper, w))


EFFECT = Effect(
    name="closure_light",
    title="unknown function in the light",
    meaning="an unknown function of one covariate acts on the light",
    stage="light",
    equation="light (1 + f(z))",
    parameters=parameters("1", 0.001),
    states=("memory", "before"),
    outputs=("light",),
    vectors=(("w", KNOTS),),
    start=step,
    step=step,
    strength="strength",
    typical=1.0,
    step_sizes=(1.0,),
)
