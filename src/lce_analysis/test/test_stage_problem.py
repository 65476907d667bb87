# SPDX-License-Identifier: Apache-2.0
"""A refit of both stages, where strip and model jump."""

import numpy as np
import pytest

from lce_analysis.diagnosis import stage_problem
from lce_analysis.diagnosis.misfit import JudgedRuns
from lce_analysis.diagnosis.stage_problem import Data, StagedFit, refit_stages
from lce_analysis.options import DiagnoseOptions
from lce_analysis.prediction import simulation_input
from lce_data.channels import DISPLACEMENT
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

STRIP = default_model("lumped", "dynamic").set({"dynamic.spinodal": 1e4})
WRONG = STRIP.set({"dynamic.t_star": STRIP["dynamic.t_star"] + 0.4})


def _run(heated_s: float) -> Run:
    """A strip that jumps on cooling, seen by both sensors."""
    rng, time = np.random.default_rng(round(heated_s)), np.arange(0.0, 120.0, 0.01)
    power = np.where(time < heated_s, 1.2, 0.0)
    true = simulate(STRIP, time, power)
    temperature = Series(time[::10], true.temperature_k[::10] + 0.05 * rng.standard_normal(time[::10].size))
    displacement = Series(time, true.displacement_m + 4e-6 * rng.standard_normal(time.size))
    return Run.of(f"pulse-{heated_s:g}", Series(time, power), temperature, displacement)


@pytest.fixture(scope="module")
def data() -> Data:
    """Two runs, laid out for a model whose T* is off."""
    runs = [_run(heated_s) for heated_s in (28.0, 33.0)]
    return Data(JudgedRuns.of(runs), tuple(simulation_input(run, WRONG) for run in runs)).coarse(0.05)


def _refitted(data: Data, model: Model) -> StagedFit:
    return refit_stages(model, data, [], DiagnoseOptions(), silent)


def _off_k(fit: StagedFit) -> float:
    return abs(fit.model["dynamic.t_star"] - STRIP["dynamic.t_star"])


def test_a_refit_finds_t_star_where_the_strip_jumps(data: Data, monkeypatch: pytest.MonkeyPatch) -> None:
    found = _refitted(data, WRONG)
    assert _off_k(found) < 0.02
    assert found.mean_squares[DISPLACEMENT] == pytest.approx(1.0, abs=0.1)
    # Without a look at the jumps: these samples do not count while they are on the wrong side.
    monkeypatch.setattr(stage_problem, "jumping_with_the_strip", lambda *_: None)
    assert _off_k(_refitted(data, WRONG)) > 2.0 * _off_k(found)


def test_a_t_star_that_is_right_stays(data: Data) -> None:
    found = _refitted(data, STRIP)
    assert _off_k(found) < 0.02
    assert found.mean_squares[DISPLACEMENT] == pytest.approx(1.0, abs=0.1)
