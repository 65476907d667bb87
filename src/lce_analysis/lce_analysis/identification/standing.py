# SPDX-License-Identifier: Apache-2.0
"""A model that was fitted before, beside runs, as the least squares at whose optimum it stands."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lce_analysis.identification.problem import Problem, observed_series, start_conditions
from lce_analysis.identification.stages import MECHANICAL_STAGES, acts_on_temperature
from lce_analysis.options import Drive
from lce_analysis.prediction import (
    MECHANICAL,
    measured_drive,
    model_of_run,
    simulation_input,
    start_temperature,
    with_ambient_at_rest,
)
from lce_data.channels import SENSORS, TEMPERATURE, Channel
from lce_data.noise import sensor_noise
from lce_data.run import Run
from lce_model import Model


def standing_problems(model: Model, runs: Sequence[Run], drive: Drive = "model") -> tuple[Problem, ...]:
    """The least squares of a model beside runs, each series in units of its sensor's noise.

    One problem with all its parameters; two where the measured temperature drives the deformation: that of the heat
    judged on the temperature, and that of the deformation on all other sensors.

    Raises LceError if a run lacks what the model needs.
    """
    model = with_ambient_at_rest(model, runs)
    inputs = [simulation_input(run, model) for run in runs]
    own = [model_of_run(model, run) for run in runs]
    starts_k = np.array([start_temperature(i, m) for i, m in zip(inputs, own, strict=True)])
    free = tuple(i for i, v in enumerate(model.values) if model.searches(v))
    sigma = sensor_noise(runs, [c for c in SENSORS if model.predicts(c)])

    def among(channels: Sequence[Channel]) -> dict[Channel, float]:
        return {c: s for c, s in sigma.items() if c in channels}

    whole = Problem(model, inputs, free, starts_k, observed_series(inputs, sigma), *start_conditions(inputs, model))
    if drive == "model" or model.deformation == "none":
        return (whole,)
    heat = {t.name for t in model.terms if t.stage not in MECHANICAL_STAGES or acts_on_temperature(t)}
    of_heat = tuple(i for i in free if model.values[i].term in heat)
    moved = [i for i, run in enumerate(runs) if any(c in run.series for c in MECHANICAL)]
    driven = [measured_drive(inputs[i], own[i], float(starts_k[i])) for i in moved]
    return (
        replace(whole, free=of_heat, observed=observed_series(inputs, among([TEMPERATURE]))),
        Problem(
            model,
            driven,
            tuple(i for i in free if i not in of_heat),
            starts_k[moved],
            observed_series(driven, among(MECHANICAL)),
        ),
    )
