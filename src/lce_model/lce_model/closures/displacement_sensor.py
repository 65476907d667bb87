# SPDX-License-Identifier: Apache-2.0
"""An unknown function f(z) of one covariate is added to what the distance sensor shows."""

from lce_model.closures.covariates import follow
from lce_model.closures.forms import KNOTS, Floats, value
from lce_model.closures.place import parameters
from lce_model.effects import Effect


def step(
    measured_displacement: float,
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
    """Memory of the covariate and its value before, and what the distance sensor shows [m]."""
    memory, before, z = follow(
        covariate, tau, temperature, warming, power, order, displacement, direction, dt, elapsed_time, memory, before
    )
    return memory, before, measured_displacement + strength * value(form, z, z0, a, b, lower, upper, w)


EFFECT = Effect(
    name="closure_displacement_sensor",
    title="unknown function in the distance sensor",
    meaning="an unknown function of one covariate acts on the distance sensor",
    stage="sensor",
    equation="d_meas = d + f(z)",
    parameters=parameters("m", 1e-06),
    states=("memory", "before"),
    outputs=("measured_displacement",),
    vectors=(("w", KNOTS),),
    start=step,
    step=step,
    strength="strength",
    typical=1.0,
    step_sizes=(1.0,),
)
