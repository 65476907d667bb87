# SPDX-License-Identifier: Apache-2.0
"""A drift of the distance sensor beside a base model that is wrong; the strip is made by numpy."""

import numpy as np
import pytest
from scipy.signal import lsim

from lce_analysis.diagnosis import diagnose
from lce_analysis.identification import fit
from lce_data.channels import DISPLACEMENT
from lce_data.run import Run, Series
from lce_model import default_model
from lce_model.effects import find

RATE = 1.15e-6
"""Of the drift [m/s]."""


def strip(name: str, seed: int, rate: float) -> Run:
    """A loop of two edges 2 K apart, with ripples that no model of the library has."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 80.0, 0.05)
    power = np.repeat(rng.uniform(0.2, 1.6, 8), time.size // 8) * (time > 2.0) * (time < 70.0)
    _, rise, _ = lsim(([40.0], [8.0, 1.0]), power, time)
    edge = np.empty_like(rise)
    at = -1.0
    for i, excess in enumerate(rise):
        at = edge[i] = min(max(at, excess - 1.0), excess + 1.0)
    contraction = 6e-4 / (1.0 + np.exp(-(edge - 25.0) / 5.0)) + 1e-5 * np.sin(edge / 1.5)
    displacement = contraction - contraction[0] + rate * time + 3e-6 * rng.standard_normal(time.size)
    temperature = 298.0 + rise + 0.05 * rng.standard_normal(time.size)
    return Run.of(name, Series(time, power), Series(time, temperature), Series(time, displacement), sha256=name)


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "named"), [(RATE, ["displacement_drift"]), (0.0, [])])
def test_a_drift_that_the_residual_shows_as_a_line_is_named_beside_a_wrong_base(rate: float, named: list[str]) -> None:
    runs, test = [strip(f"run-{i}", i, rate) for i in range(6)], [strip("held-out", 9, rate)]
    model = fit(default_model("lumped", "equilibrium"), runs).model
    found = diagnose(model, runs, test, [find(name) for name in ("displacement_drift", "creep", "residual_strain")])
    assert found.as_json()["added"] == named
    assert found.test.misfit["after"].rms[DISPLACEMENT] > 2.0
