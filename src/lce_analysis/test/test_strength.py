# SPDX-License-Identifier: Apache-2.0
"""One strength or as many as runs: a drift of the distance sensor, known in every run."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from lce_analysis.diagnosis.linearized_fit import LinearizedFit, refit
from lce_analysis.diagnosis.misfit import JudgedRuns
from lce_analysis.diagnosis.stage_problem import Data, with_candidates
from lce_analysis.diagnosis.strength import Estimate, Strengths, strengths
from lce_analysis.identification.coarse import STEP_S
from lce_analysis.identification.problem import Problem
from lce_analysis.prediction import simulation_input
from lce_data.channels import SENSORS
from lce_data.progress import silent
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import find

# The effects of test_diagnose.py, so that the same kernel serves both.
NAMES = ("creep", "thermal_gradient", "ambient_drift", "displacement_drift", "radiation")
RATE = "displacement_drift.rate"
TRUE = 5e-7


@pytest.fixture(scope="module")
def fitted(strip: Model, recorded: Callable[..., Run]) -> Callable[..., LinearizedFit]:
    """Runs whose distance sensor drifts by these rates [m/s], fitted by one strip and one rate."""

    def fit(rates: Sequence[float], last_without_distance: bool = False) -> LinearizedFit:
        runs = []
        for i, rate in enumerate(rates):
            run = recorded(
                f"run {i}",
                seed=i,
                duration_s=60.0,
                power=lambda t, i=i: np.where((t > 1.0) & (t < 15.0 + 5.0 * i), 1.3, 0.0),
                extra=lambda t, k, d, rate=rate: rate * t,
                displacement=not (last_without_distance and i == len(rates) - 1),
            )
            runs.append(run)
        model = with_candidates(strip, [find(name) for name in NAMES])
        data = Data(JudgedRuns.of(runs), tuple(simulation_input(run, model) for run in runs)).coarse(STEP_S)
        free = [model.index(key) for key in ("lumped.gain", "lumped.tau", "equilibrium.c_r", "stretch_law.alpha", RATE)]
        starts = np.full(len(runs), model["ambient.t_env"])
        return refit(Problem(model, data.inputs, tuple(sorted(free)), starts, data.observed(SENSORS)), "", silent, 30)

    return fit


@pytest.fixture(scope="module")
def alike(fitted: Callable[..., LinearizedFit]) -> LinearizedFit:
    """Three runs with the same drift."""
    return fitted([TRUE] * 3)


def _of(fit: LinearizedFit) -> Strengths:
    return strengths(fit, fit.problem.free.index(fit.problem.model.index(RATE)))


def _near(estimate: Estimate | None, truth: float) -> bool:
    return estimate is not None and abs(estimate.value - truth) < 4.0 * estimate.standard_error


def test_every_run_gives_the_true_strength_within_its_error(alike: LinearizedFit) -> None:
    found = _of(alike)
    assert _near(found.overall, TRUE) and _near(found.mean, TRUE)
    assert all(_near(estimate, TRUE) for estimate in found.by_run)
    assert found.overall.standard_error < 0.05 * TRUE
    assert found.overall.value == alike.problem.model[RATE]
    assert found.spread < 0.05 * TRUE


def test_a_run_with_another_strength_is_told_by_the_spread(fitted: Callable[..., LinearizedFit]) -> None:
    rates = (TRUE, TRUE, -TRUE)
    found = _of(fitted(rates))
    assert all(_near(estimate, rate) for estimate, rate in zip(found.by_run, rates, strict=True))
    assert found.spread == pytest.approx(np.std(rates, ddof=1), rel=0.2)
    assert found.mean.standard_error > 5.0 * max(e.standard_error for e in found.by_run if e is not None)


def test_a_run_that_says_nothing_has_no_strength(fitted: Callable[..., LinearizedFit]) -> None:
    found = _of(fitted([TRUE] * 3, last_without_distance=True))
    assert found.by_run[2] is None
    assert all(_near(estimate, TRUE) for estimate in found.by_run[:2])
    assert _near(found.mean, TRUE)


def test_correlated_residuals_make_errors_larger(alike: LinearizedFit) -> None:
    rng = np.random.default_rng(3)
    white = rng.standard_normal(alike.residual.size)
    slow = lfilter([np.sqrt(1.0 - 0.95**2)], [1.0, -0.95], white)  # of the same variance
    plain, clustered = (_of(replace(alike, residual=residual)) for residual in (white, slow))
    assert plain.inflation < 2.5
    assert clustered.inflation > 5.0
    assert clustered.overall.standard_error > 2.0 * plain.overall.standard_error


def test_runs_beyond_their_errors_are_weighed_alike() -> None:
    one = Estimate(1.0, 0.1)
    exact, scattered = (Strengths("rate", one, 1.0, 1.0, (one, Estimate(x, 0.2), None)) for x in (1.05, 3.0))
    assert exact.spread == 0.0
    assert exact.mean.value == pytest.approx((1.0 / 0.01 + 1.05 / 0.04) / (1.0 / 0.01 + 1.0 / 0.04))
    assert exact.mean.standard_error == pytest.approx((1.0 / 0.01 + 1.0 / 0.04) ** -0.5)
    assert scattered.spread == pytest.approx(np.sqrt(0.5 * 2.0**2 - 0.025), rel=0.01)
    assert scattered.mean.value == pytest.approx(2.0, abs=0.05)
    assert scattered.mean.standard_error > 0.9


def test_a_single_run_gives_the_strength_of_all() -> None:
    one = Estimate(1.0, 0.1)
    for by_run in ((one,), (one, None), (None, None)):
        alone = Strengths("rate", one, 1.0, 1.0, by_run)
        assert alone.mean is one
        assert alone.spread == 0.0
