# SPDX-License-Identifier: Apache-2.0
"""What a jump of the strip or of the model does to a fit: the samples around it, and when it happens."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_analysis.identification.coarse import coarse
from lce_analysis.identification.discontinuities import (
    jumping_with_the_strip,
    squared_error,
    without_discontinuities,
)
from lce_analysis.identification.problem import Problem, observed_series
from lce_analysis.jumps import discontinuities
from lce_analysis.prediction import simulation_input
from lce_data.channels import DISPLACEMENT
from lce_data.run import Run, Series
from lce_model import Variation, default_model, simulate

Floats = NDArray[np.float64]
NOISE = {DISPLACEMENT: 4e-6}


def _wave(time: Floats) -> Floats:
    return 0.7 - 0.7 * np.cos(0.4 * time)


def test_samples_of_a_motion_that_the_grid_does_not_resolve_are_left_out() -> None:
    strip, time = default_model("lumped", "dynamic"), np.arange(0.0, 45.0, 0.01)
    displacement = simulate(strip, time, _wave(time)).displacement_m
    displacement += NOISE[DISPLACEMENT] * np.random.default_rng(0).standard_normal(time.size)
    fine = simulation_input(Run.of("wave", Series(time, _wave(time)), displacement=Series(time, displacement)), strip)
    found = coarse(fine)
    problem = Problem(strip, [found], (), np.array([strip["ambient.t_env"]]), observed_series([found], NOISE))
    searched = without_discontinuities(problem, [fine])
    kept = searched.observed[0].counted
    assert kept > 0.9 * problem.size
    before, after = (float(np.sum(p.residuals(p.first()) ** 2)) for p in (problem, searched))
    assert before / problem.size > 10.0
    assert after / kept == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / kept))


def test_a_jump_at_the_wrong_time_counts_for_as_much_as_it_lasts() -> None:
    """Samples away from the jumps, measured and modelled, do not show that the model jumps too early."""
    strip, time = default_model("lumped", "dynamic").set({"dynamic.spinodal": 1e4}), np.arange(0.0, 45.0, 0.01)
    modelled = simulate(strip, time, _wave(time)).displacement_m
    jump = discontinuities(time, modelled, NOISE[DISPLACEMENT])[0]
    noise = NOISE[DISPLACEMENT] * np.random.default_rng(0).standard_normal(time.size)

    def errors(late_s: float) -> tuple[float, float]:
        """Mean squared error away from the jumps, and the squared error that counts those around them."""
        before = int(np.searchsorted(time, jump)) - 1
        waits = (time >= jump) & (time < jump + late_s)
        measured = np.where(waits, modelled[before], modelled) + noise
        run = Run.of("wave", Series(time, _wave(time)), displacement=Series(time, measured))
        whole = simulation_input(run, strip)
        problem = Problem(strip, [whole], (), np.array([strip["ambient.t_env"]]), observed_series([whole], NOISE))
        away = without_discontinuities(problem)
        return float(np.mean(away.residuals(away.first()) ** 2)), squared_error(problem)

    (at_once, least), (late, most) = errors(0.0), errors(0.4)
    assert late == pytest.approx(at_once, abs=0.02)
    # For 0.4 s, 40 samples are off by 3 times the noise instead of once.
    assert most - least == pytest.approx(40 * (3.0**2 - 1.0), rel=0.1)


@pytest.mark.parametrize("off_k", [0.4, -0.4])
def test_t_star_is_read_off_the_jumps_of_the_strip(off_k: float) -> None:
    """Turns, at which both jump at the same time, say nothing of it."""
    problem = _jumping(off_k)
    found = jumping_with_the_strip(problem)
    assert found is not None
    assert found.model["dynamic.t_star"] == pytest.approx(problem.model["dynamic.t_star"] - off_k, abs=0.02)
    assert jumping_with_the_strip(found) is None


def test_where_model_and_strip_jump_together_t_star_is_left_to_the_fit() -> None:
    assert jumping_with_the_strip(_jumping(0.0)) is None


def test_a_t_star_that_is_fixed_or_differs_from_run_to_run_is_not_read_off_the_jumps() -> None:
    problem = _jumping(0.4)
    assert jumping_with_the_strip(replace(problem, free=())) is None
    varying = problem.model.varying({"dynamic.t_star": Variation()})
    assert jumping_with_the_strip(replace(problem, model=varying)) is None


def _jumping(off_k: float) -> Problem:
    """A strip that jumps, and a model of it whose T* is off by so much."""
    time = np.arange(0.0, 120.0, 0.01)
    power = np.where(time < 33.0, 1.2, 0.0)
    model = default_model("lumped", "dynamic").set({"dynamic.spinodal": 1e4})
    measured = simulate(model, time, power).displacement_m
    measured += NOISE[DISPLACEMENT] * np.random.default_rng(0).standard_normal(time.size)
    wrong = model.set({"dynamic.t_star": model["dynamic.t_star"] + off_k})
    whole = simulation_input(Run.of("pulse", Series(time, power), displacement=Series(time, measured)), wrong)
    starts_k = np.array([wrong["ambient.t_env"]])
    return Problem(wrong, [whole], (wrong.index("dynamic.t_star"),), starts_k, observed_series([whole], NOISE))
