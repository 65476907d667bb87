# SPDX-License-Identifier: Apache-2.0
"""The Jacobian of a fit is that of its residuals, for every kind of variable."""

from dataclasses import replace

import numpy as np
import pytest

from lce_analysis.identification.problem import Problem, observed_series
from lce_analysis.prediction import simulation_input
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import RunValue, Variation, default_model, simulate

MODEL = default_model("lumped", "kinetic").set({"ambient.t_env": 301.0})
FREE = ("ambient.t_env", "lumped.gain", "lumped.tau", "kinetic.t_c", "stretch_law.alpha")
STARTS_K = np.array([301.0, 303.0, 305.0, 302.0])


@pytest.fixture(scope="module")
def several() -> Problem:
    """Four runs: one starts at the ambient temperature, two at temperatures to be found, one at a known one."""
    inputs = []
    for number, start_k in enumerate(STARTS_K):
        time_s = 0.1 * np.arange(300 + 20 * number)
        power_w = np.where((time_s > 1.0) & (time_s < 15.0), 1.0 + 0.1 * number, 0.0)
        out = simulate(MODEL, time_s, power_w, initial_temperature_k=float(start_k))
        series = (Series(time_s, y) for y in (power_w, out.temperature_k + 0.1, out.displacement_m + 1e-5))
        inputs.append(simulation_input(Run.of(f"run {number}", *series, sha256="0" * 64), MODEL))
    free = tuple(MODEL.index(key) for key in FREE)
    observed = observed_series(inputs, {TEMPERATURE: 0.05, DISPLACEMENT: 4e-6})
    return Problem(MODEL, inputs, free, STARTS_K, observed, free_starts=(1, 3), at_ambient=(0,))


@pytest.mark.parametrize("varies", [False, True])
@pytest.mark.parametrize("central", [False, True])
def test_the_jacobian_is_that_of_the_residuals(several: Problem, varies: bool, central: bool) -> None:
    if varies:
        by_run = {p.run.name: RunValue(30.0 + i) for i, p in enumerate(several.inputs)}
        several = replace(several, model=MODEL.varying({"lumped.gain": Variation(1.0, by_run)}))
    variables = several.first()
    assert variables.size == len(FREE) + (len(STARTS_K) if varies else 0) + 2
    jacobian = several.jacobian(variables, central)
    for column, step in enumerate([1e-5] * (variables.size - 2) + [1e-3] * 2):
        shift = step * np.eye(variables.size)[column]
        slope = (several.residuals(variables + shift) - several.residuals(variables - shift)) / (2.0 * step)
        np.testing.assert_allclose(jacobian[:, column], slope, atol=1e-4 * np.abs(slope).max(), err_msg=str(column))
    known = several.jacobian(variables, central, several.residuals(variables))
    np.testing.assert_array_equal(known, jacobian)
