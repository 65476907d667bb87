# SPDX-License-Identifier: Apache-2.0
"""The temperature that the order follows is shifted by an unknown function f(z) of one covariate."""

from lce_model.closures.covariates import follow
from lce_model.closures.forms import KNOTS, Floats, value
from lce_model.closures.place import parameters
from lce_model.effects import Effect


def step(
    order_temperature: float,
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
    """Memory of the covariate and its value before, and the temperature [K] that the order follows."""
    memory, before, z = follow(
        covariate, tau, temperature, warming, power, order, displacement, direction, dt, elapsed_time, memory, before
    )
    return memory, before, order_temperature + strength * value(form, z, z0, a, b, lower, upper, w)


EFFECT = Effect(
    name="closure_order",
    title="unknown function in the order",
    meaning="an unknown function of one covariate acts on the order",
    stage="order",
    equation="T -> T + f(z) for the order",
    parameters=parameters("K", 0.01),
    states=("memory", "before"),
    outputs=("order_temperature",),
    vectors=(("w", KNOTS),),
    start=step,
    step=step,
    strength="strength",
    typical=1.0,
    step_sizes=(1.0,),
)
