# SPDX-License-Identifier: Apache-2.0
"""Where a search by least squares ends, and when."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.signal import lfilter

from lce_analysis.identification.least_squares import SLOW_STEPS, levenberg_marquardt
from lce_analysis.identification.problem import Problem, observed_series
from lce_analysis.prediction import simulation_input
from lce_data.channels import TEMPERATURE
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import default_model

MODEL = default_model("lumped", "none")


@pytest.fixture(scope="module")
def problem() -> Problem:
    """A heater with two time constants, which one cannot explain; the gain and the time constant are far off."""
    time_s = 0.1 * np.arange(600)
    power_w = np.where((time_s > 2.0) & (time_s < 35.0), 1.0, 0.0)
    rise = 30.0 * power_w
    for tau_s in (20.0, 5.0):
        decay = np.exp(-0.1 / tau_s)
        rise = lfilter([1.0 - decay], [1.0, -decay], rise)
    run = Run.of("run", Series(time_s, power_w), Series(time_s, 295.0 + rise), sha256="0" * 64)
    given = MODEL.set({"lumped.gain": 5000.0, "lumped.tau": 5000.0, "ambient.t_env": 295.0})
    run_input = simulation_input(run, given)
    free = tuple(given.index(key) for key in ("lumped.gain", "lumped.tau", "ambient.t_env"))
    return Problem(given, [run_input], free, np.array([295.0]), observed_series([run_input], {TEMPERATURE: 0.05}))


def test_the_minimum_is_that_of_minpack(problem: Problem) -> None:
    found = levenberg_marquardt(problem, problem.first(), "", silent)
    # From a start of its own: from far off it ends elsewhere, higher.
    near = found.variables + 0.1
    true = least_squares(problem.penalized, near, problem.penalized_jacobian, method="lm", ftol=1e-9, xtol=1e-9)
    assert found.rms**2 * problem.size == pytest.approx(2.0 * true.cost, rel=1e-6)
    np.testing.assert_allclose(problem.split(found.variables)[0], problem.split(true.x)[0], rtol=1e-4)


def test_an_interrupted_search_keeps_its_best(problem: Problem) -> None:
    told: list[float] = []

    def interrupting(label: str, done: int, total: int, rms: float) -> None:
        told.append(rms)
        if done == 3:
            raise KeyboardInterrupt

    found = levenberg_marquardt(problem, problem.first(), "", interrupting)
    assert found.interrupted
    assert found.rms == told[-1] < told[0]
    assert found.rms == pytest.approx(float(np.sqrt(np.mean(problem.residuals(found.variables) ** 2))))


def test_a_search_ends_after_so_many_steps(problem: Problem) -> None:
    start = problem.first()
    few, more = (levenberg_marquardt(problem, start, "", silent, iterations=n) for n in (2, 4))
    assert more.rms < few.rms < float(np.sqrt(np.mean(problem.residuals(start) ** 2)))


def test_a_search_that_hardly_gets_on_ends_with_its_best(problem: Problem) -> None:
    start = problem.first()
    to_the_end = levenberg_marquardt(problem, start, "", silent)
    slow = levenberg_marquardt(problem, start, "", silent, slow=1e9)
    assert SLOW_STEPS < slow.evaluations < to_the_end.evaluations
    assert not slow.interrupted
    assert to_the_end.rms <= slow.rms
    assert slow.rms == pytest.approx(float(np.sqrt(np.mean(problem.residuals(slow.variables) ** 2))))


def test_a_search_that_gets_on_goes_to_the_end(problem: Problem) -> None:
    start = problem.first()
    to_the_end = levenberg_marquardt(problem, start, "", silent)
    assert levenberg_marquardt(problem, start, "", silent, slow=1e-12).rms == pytest.approx(to_the_end.rms, rel=1e-6)


def test_the_jacobian_is_the_same_in_pieces(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    start = problem.first()
    whole = []
    for cores in (1, 2, 3, 100):
        monkeypatch.setattr("lce_analysis.identification.problem._CORES", cores)
        whole.append(problem.jacobian(start))
    assert whole[0].shape == (600, 3)
    for pieces in whole[1:]:
        np.testing.assert_array_equal(pieces, whole[0])
