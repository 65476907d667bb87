# SPDX-License-Identifier: Apache-2.0
"""Intervals from resampled residuals: those of least squares where it is right, wider where noise is correlated."""

import numpy as np
import pytest
from scipy.signal import lfilter

from lce_analysis.identification import fit
from lce_analysis.identification.bootstrap import bootstrap
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import default_model, simulate

pytestmark = pytest.mark.slow

HEATER = default_model("lumped", "none").set({"lumped.tau": 31.0, "lumped.gain": 22.0})


def runs(seed: int, phi: float = 0.0) -> list[Run]:
    """Two runs whose noise of 0.06 K is correlated by φ from sample to sample."""
    found = []
    for k in range(2):
        time = np.arange(0.0, 90.0, 0.1)
        power = np.where((time > 2.0) & (time < 30.0 + 10.0 * k), 1.2, 0.0)
        white = np.random.default_rng((seed, k)).standard_normal(time.size)
        noise = 0.06 * np.sqrt(1.0 - phi**2) * lfilter([1.0], [1.0, -phi], white)
        made = simulate(HEATER, time, power).temperature_k + noise
        found.append(Run.of(f"run-{k}", Series(time, power), Series(time, made)))
    return found


def test_with_white_noise_it_agrees_with_the_standard_errors() -> None:
    found = fit(default_model("lumped", "none"), runs(0))
    drawn = bootstrap(found.problem, 150, 0, silent)
    assert drawn.keys == ("ambient.t_env", "lumped.gain", "lumped.tau")
    errors = [v.standard_error for v in found.model.values if not v.fixed]
    assert drawn.draws.std(axis=0) == pytest.approx(errors, rel=0.3)
    low, high = drawn.interval()
    assert np.all((low < drawn.best) & (drawn.best < high))


def test_intervals_hold_the_truth_as_often_as_they_say_when_noise_is_correlated() -> None:
    held = []
    for seed in range(12):
        drawn = bootstrap(fit(default_model("lumped", "none"), runs(seed, phi=0.9)).problem, 60, seed, silent)
        low, high = drawn.interval()
        truth = np.array([HEATER[key] for key in drawn.keys])
        held += list((low <= truth) & (truth <= high))
    assert np.mean(held) > 0.75  # of 95 %, with 36 of them and few draws; white errors would be four times too small


def test_a_draw_is_the_same_whatever_was_drawn_before() -> None:
    problem = fit(default_model("lumped", "none"), runs(0)).problem
    assert np.array_equal(bootstrap(problem, 3, 7, silent).draws, bootstrap(problem, 5, 7, silent).draws[:3])
    assert not np.array_equal(bootstrap(problem, 3, 8, silent).draws, bootstrap(problem, 3, 7, silent).draws)


def test_ctrl_c_keeps_what_was_drawn() -> None:
    def impatient(label: str, done: int, total: int, rms: float) -> None:
        if done == 4:
            raise KeyboardInterrupt

    problem = fit(default_model("lumped", "none"), runs(0)).problem
    assert bootstrap(problem, 50, 0, impatient).draws.shape == (4, 3)


def test_a_model_that_jumps_does_not_know_its_time_constant_to_the_sample() -> None:
    """The equilibrium model jumps at every reversal, and the time constant says when: a slope without end."""
    time = np.arange(0.0, 100.0, 0.01)
    lit = (time > 10.0) & (time < 70.0)
    power = np.where(lit, 1.05 - 0.55 * np.cos(2.0 * np.pi * (time - 10.0) / 30.0), 0.0)
    noise, strip = np.random.default_rng(0), default_model()
    made = simulate(strip.add("creep").set({"creep.share": 0.12, "creep.tau_v": 12.0}), time, power)
    warm = Series(time[::10], made.temperature_k[::10] + 0.06 * noise.standard_normal(1000))
    moved = Series(time, made.displacement_m + 4e-6 * noise.standard_normal(time.size))
    # Few parameters: the search for the others takes seconds.
    fixed = [v.key for v in strip.values if v.term == "equilibrium" and v.name not in ("t_star_r", "t_star_c")]
    found = fit(strip.fix(fixed), [Run.of("run", Series(time, power), warm, moved)])
    drawn = bootstrap(found.problem, 12, 0, silent)
    spread = dict(zip(drawn.keys, drawn.draws.std(axis=0), strict=True))["lumped.tau"]
    error = found.model.values[found.model.index("lumped.tau")].standard_error
    assert error is not None
    assert error > 0.3 * spread
