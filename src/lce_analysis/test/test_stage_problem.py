# SPDX-License-Identifier: Apache-2.0
"""A refit of both stages, where strip and model jump."""

import numpy as np
import pytest

from lce_analysis.diagnosis import stage_problem
from lce_analysis.diagnosis.misfit import JudgedRuns
from lce_analysis.diagnosis.stage_problem import Data, StagedFit, refit_stages
from lce_analysis.options import DiagnoseOptions
from lce_analysis.prediction import simulation_input
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import default_model, simulate

STRIP = default_model("lumped", "dynamic").set({"dynamic.spinodal": 1e4})


def _run(heated_s: float) -> Run:
    """A strip that jumps on cooling, seen by both sensors."""
    rng, time = np.random.default_rng(round(heated_s)), np.arange(0.0, 120.0, 0.01)
    power = np.where(time < heated_s, 1.2, 0.0)
    true = simulate(STRIP, time, power)
    temperature = Series(time[::10], true.temperature_k[::10] + 0.05 * rng.standard_normal(time[::10].size))
    displacement = Series(time, true.displacement_m + 4e-6 * rng.standard_normal(time.size))
    return Run.of(f"pulse-{heated_s:g}", Series(time, power), temperature, displacement)


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    """Two of them."""
    return [_run(heated_s) for heated_s in (28.0, 33.0)]


def _refitted(runs: list[Run], off_k: float) -> StagedFit:
    """The strip's own model, refitted from where T* is off by so much."""
    model = STRIP.set({"dynamic.t_star": STRIP["dynamic.t_star"] + off_k})
    data = Data(JudgedRuns.of(runs), tuple(simulation_input(run, model) for run in runs)).coarse(0.05)
    return refit_stages(model, data, [], DiagnoseOptions(), silent)


@pytest.mark.parametrize("off_k", [-1.5, 1.5])
def test_a_refit_finds_t_star_where_the_strip_jumps(
    runs: list[Run], off_k: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = _refitted(runs, off_k)
    assert found.model["dynamic.t_star"] == pytest.approx(STRIP["dynamic.t_star"], abs=0.1)
    assert found.worst == pytest.approx(1.0, abs=0.05)
    # Without a look at the jumps, the samples between those of strip and model give no slope to find them by.
    monkeypatch.setattr(stage_problem, "jumping_with_the_strip", lambda *_: None)
    assert _refitted(runs, off_k).worst > 2.0 * found.worst


def test_a_t_star_that_is_right_stays(runs: list[Run]) -> None:
    found = _refitted(runs, 0.0)
    assert found.model["dynamic.t_star"] == pytest.approx(STRIP["dynamic.t_star"], abs=0.02)
    assert found.worst == pytest.approx(1.0, abs=0.05)
