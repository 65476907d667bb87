# SPDX-License-Identifier: Apache-2.0
"""A long recording: a sparse grid where nothing happens, and a fit to every sample."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.identification import fit
from lce_analysis.identification.coarse import coarse, is_long
from lce_analysis.prediction import simulation_input
from lce_data.run import Run
from lce_model import Model, default_model

Floats = NDArray[np.float64]


def _cycles(time: Floats) -> Floats:
    """Twelve minutes of cycles of a minute, eight seconds of light in each [W]."""
    return np.where(time % 60.0 < 8.0, 1.2, 0.0)


@pytest.fixture(scope="module")
def long_run(strip: Model, recorded: Callable[..., Run]) -> Run:
    return recorded(power=_cycles, duration_s=720.0)


def test_the_grid_is_sparse_and_the_light_the_same(strip: Model, long_run: Run) -> None:
    fine = simulation_input(long_run, strip)
    found = coarse(fine)
    assert is_long(fine) and not is_long(found)
    assert found.time_s.size < 0.15 * fine.time_s.size
    assert found.power_w[:-1] @ np.diff(found.time_s) == pytest.approx(fine.power_w[:-1] @ np.diff(fine.time_s))
    assert all(size.value.size <= found.time_s.size for size in found.run.measured.values())


def test_the_fit_is_that_of_every_sample(strip: Model, long_run: Run) -> None:
    found = fit(default_model("lumped", "none"), [long_run]).problem
    assert found.inputs[0].time_s.size == 72_000
    residual = found.residuals(found.first())
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(1.0, abs=0.1)
    for key in ("lumped.tau", "lumped.gain"):
        assert found.model[key] == pytest.approx(strip[key], rel=0.01)
