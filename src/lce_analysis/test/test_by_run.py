# SPDX-License-Identifier: Apache-2.0
"""What a value for each run would take of the error, beside plain least squares on all samples."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from lce_analysis.identification import fit
from lce_analysis.identification.by_run import ByRun, may_vary
from lce_analysis.identification.problem import Problem
from lce_data.run import Run, Series
from lce_model import default_model
from lce_model.effects import find, radiation

Floats = NDArray[np.float64]


def heater(number: int, gain: float) -> Run:
    """A minute of random powers at 10 Hz; one pole, sampled exactly."""
    rng = np.random.default_rng(number)
    time_s = 0.1 * np.arange(600)
    power_w = np.repeat(rng.uniform(0.0, 1.0, 12), 50)
    decay = np.exp(-0.1 / 20.0)
    rise = lfilter([0.0, gain * (1.0 - decay)], [1.0, -decay], power_w)
    noisy = 295.0 + rise + 0.05 * rng.standard_normal(600)
    return Run.of(f"run {number}", Series(time_s, power_w), Series(time_s, noisy), sha256=str(number))


@pytest.fixture(scope="module")
def problem() -> Problem:
    """One gain for four runs, the last of which has another."""
    runs = [heater(number, gain) for number, gain in enumerate((30.0, 30.0, 30.0, 33.0))]
    return fit(default_model("lumped", "none"), runs).problem


def plainly(problem: Problem, keys: Sequence[str]) -> Floats:
    """What is left of the residual (N,), by least squares on every sample."""
    variables = problem.first()
    jacobian, residual = problem.jacobian(variables), problem.residuals(variables)
    run_of = np.concatenate([np.full(series.size, series.run) for series in problem.observed])
    columns = [jacobian]
    for key in keys:
        column = jacobian[:, problem.free.index(problem.model.index(key))]
        columns += [np.where(run_of == run, column, 0.0)[:, None] for run in range(len(problem.inputs))]
    every = np.column_stack(columns)
    return np.asarray(residual - every @ np.linalg.lstsq(every, residual, rcond=1e-8)[0])


def by_run(problem: Problem) -> ByRun:
    variables = problem.first()
    return ByRun(problem, problem.jacobian(variables), problem.residuals(variables))


def test_an_effect_of_a_file_is_no_parameter_of_the_base_model(problem: Problem, tmp_path: Path) -> None:
    file = tmp_path / "glow.py"
    file.write_text(Path(radiation.__file__).read_text(encoding="utf-8").replace('name="radiation"', 'name="glow"'))
    effect = find(str(file))
    model = problem.model.add(effect)
    keys = [*(problem.model.values[i].key for i in problem.free), effect.strength_key]
    free = tuple(model.index(key) for key in keys)
    assert may_vary(replace(problem, model=model, free=free)) == may_vary(problem)


def test_the_gain_is_that_of_least_squares_on_every_sample(problem: Problem) -> None:
    found = by_run(problem)
    without = plainly(problem, [])
    for key in found.keys:
        left = plainly(problem, [key])
        assert found.gain(key)[0] == pytest.approx(without @ without - left @ left, rel=1e-6, abs=1e-6)
    assert max(found.keys, key=lambda key: found.gain(key)[0]) == "lumped.gain"


def test_the_run_that_differs_is_told(problem: Problem) -> None:
    _, changes = by_run(problem).gain("lumped.gain")
    assert int(np.argmax(np.abs(changes - np.median(changes)))) == 3


def test_what_all_of_them_leave_is_that_of_least_squares_on_every_sample(problem: Problem) -> None:
    found = by_run(problem)
    np.testing.assert_allclose(found.rest(found.keys), plainly(problem, found.keys), atol=1e-6)
