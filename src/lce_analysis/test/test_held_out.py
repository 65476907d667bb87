# SPDX-License-Identifier: Apache-2.0
"""Errors of data left out: of test runs as they are, of each run by the others, of each block by the rest."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from lce_analysis.comparison.compare import compare
from lce_analysis.diagnosis.held_out import BLOCKS, ITERATIONS, TOLERANCE, DataLeftOut, HeldOut
from lce_analysis.diagnosis.linearized_fit import optimum, refit
from lce_analysis.diagnosis.misfit import JudgedRuns
from lce_analysis.diagnosis.stage_problem import Data, StageProblem, with_candidates
from lce_analysis.diagnosis.trial import with_effect
from lce_analysis.identification.problem import Problem
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.prediction import simulation_input
from lce_data.channels import DISPLACEMENT
from lce_data.progress import silent
from lce_data.run import Run
from lce_model import Model, Variation
from lce_model.effects import find

# The effects of test_diagnose.py, so that the same kernel serves both.
NAMES = ("creep", "thermal_gradient", "ambient_drift", "displacement_drift", "radiation")
DRIFT = find("displacement_drift")
RATE = 5e-7
NOISE_M = 4e-6


@pytest.fixture(scope="module")
def drifting(recorded: Callable[..., Run]) -> Callable[..., list[Run]]:
    """Runs of 40 s whose distance sensor drifts by these rates [m/s]."""

    def make(*rates: float) -> list[Run]:
        return [
            recorded(
                f"run {i}",
                seed=i,
                duration_s=40.0,
                power=lambda t, i=i: np.where((t > 1.0) & (t < 15.0 + 3.0 * i), 1.3, 0.0),
                extra=lambda t, k, d, rate=rate: rate * t,
            )
            for i, rate in enumerate(rates)
        ]

    return make


@pytest.fixture(scope="module")
def whole(strip: Model) -> Model:
    return with_candidates(strip, [find(name) for name in NAMES])


def _problem(whole: Model, runs: Sequence[Run]) -> Problem:
    """T → d with few free parameters."""
    data = Data(JudgedRuns.of(runs), tuple(simulation_input(run, whole) for run in runs))
    free = tuple(sorted(whole.index(key) for key in ("equilibrium.c_r", "stretch_law.alpha")))
    starts = np.full(len(runs), whole["ambient.t_env"])
    return Problem(whole, data.inputs, free, starts, data.observed([DISPLACEMENT]))


def _stage(whole: Model, runs: Sequence[Run]) -> tuple[StageProblem, Problem]:
    """The stage at least squares, and the same with the drift."""
    fit = refit(_problem(whole, runs), "", silent, 30)
    stage = StageProblem("deformation", fit, (DRIFT,), "model")
    return stage, optimum(with_effect(fit.problem, DRIFT), "", silent, 30)


def _left_out(whole: Model, runs: Sequence[Run], tests: Sequence[Run] = ()) -> tuple[HeldOut, list[str]]:
    """Errors, and what was refitted for them."""
    labels: list[str] = []

    def note(label: str, done: int, total: int, value: float) -> None:
        labels.append(label)

    stage, with_it = _stage(whole, runs)
    left_out = DataLeftOut(JudgedRuns.of(runs), JudgedRuns.of(tests), note)
    return left_out.errors(stage, with_it, DRIFT.name), labels


def test_test_runs_are_simulated_as_they_are(whole: Model, drifting: Callable[..., list[Run]]) -> None:
    *train, test = drifting(RATE, RATE, RATE)
    stage, with_it = _stage(whole, train)
    found, refitted = _left_out(whole, train, [test])
    assert (found.how, found.names) == ("test runs", ("run 2",))
    assert refitted == []
    for misfit, problem in ((found.before, stage.fit.problem), (found.after, with_it)):
        (compared,) = compare(problem.model, [test]).runs
        assert set(misfit.rms) == {DISPLACEMENT}  # the sensor of the stage
        assert misfit.rms[DISPLACEMENT] == pytest.approx(compared.channels[DISPLACEMENT].metrics.over_noise)
    assert found.before.rms[DISPLACEMENT] > 1.5
    assert found.after.rms[DISPLACEMENT] == pytest.approx(1.0, abs=0.05)


def test_a_sensor_that_one_run_alone_shows_is_judged_by_blocks_of_it(
    whole: Model, drifting: Callable[..., list[Run]]
) -> None:
    first, second = drifting(RATE, RATE)
    found, _ = _left_out(whole, [first, second.with_series(DISPLACEMENT, None)])
    assert found.how == "each block in turn"


def test_runs_that_do_not_show_the_sensor_of_a_stage_do_not_judge_it(
    whole: Model, drifting: Callable[..., list[Run]]
) -> None:
    *train, test = drifting(RATE, RATE, RATE)
    found, _ = _left_out(whole, train, [test.with_series(DISPLACEMENT, None)])
    assert (found.how, found.names) == ("each run in turn", ("run 0", "run 1"))
    assert found.before.rms[DISPLACEMENT] > 1.5 > found.after.rms[DISPLACEMENT]


def test_the_refit_without_a_run_does_not_see_it(whole: Model, drifting: Callable[..., list[Run]]) -> None:
    runs = drifting(RATE, 0.0, 0.0)
    found, refitted = _left_out(whole, runs)
    assert (found.how, found.names) == ("each run in turn", ("run 0", "run 1", "run 2"))
    assert {f"{way} without {name}" for way in ("as it is", "with displacement_drift") for name in found.names} <= {
        label.partition(":")[0] for label in refitted
    }
    before, after = (m.total[DISPLACEMENT] / m.samples[DISPLACEMENT] for m in (found.before, found.after))
    assert after[0] == pytest.approx(
        before[0], rel=0.1
    )  # the others, which do not drift, do not help the one that does
    assert (after[1:] > before[1:] + 0.05).all()  # and the one that does spoils the others


def test_the_error_of_a_run_is_that_of_a_fit_to_the_others(whole: Model, drifting: Callable[..., list[Run]]) -> None:
    runs = drifting(RATE, 0.5 * RATE)
    found, _ = _left_out(whole, runs)
    stage, with_it = _stage(whole, runs)
    others = _problem(whole, runs[1:])
    for misfit, problem in ((found.before, stage.fit.problem), (found.after, with_it)):
        start = Problem(problem.model, others.inputs, problem.free, others.starts_k, others.observed)
        alone = optimum(start, "", silent, ITERATIONS, TOLERANCE)
        wanted = JudgedRuns.of(runs[:1]).misfit(alone.model).total[DISPLACEMENT]
        assert misfit.total[DISPLACEMENT][:1] == pytest.approx(wanted, rel=1e-9)


def test_the_blocks_of_a_single_run_hold_every_sample_once(whole: Model, drifting: Callable[..., list[Run]]) -> None:
    """But for those around the jump of the strip where the light goes off."""
    runs = drifting(RATE)
    found, _ = _left_out(whole, runs)
    assert found.how == "each block in turn"
    assert found.names == tuple(f"run 0, block {i + 1} of {BLOCKS}" for i in range(BLOCKS))
    for misfit in (found.before, found.after):
        samples, series = misfit.samples[DISPLACEMENT], runs[0].series[DISPLACEMENT]
        away = away_from(discontinuities(series.time_s, series.value, NOISE_M), series.time_s)
        assert samples.shape == (BLOCKS,)
        assert samples.sum() == away.sum()
        assert np.ptp(samples) <= 2 + np.count_nonzero(~away)
    assert found.after.rms[DISPLACEMENT] == pytest.approx(1.0, abs=0.1)
    assert found.before.rms[DISPLACEMENT] > 1.3


def test_a_block_is_predicted_from_the_others(whole: Model, recorded: Callable[..., Run]) -> None:
    """What only one block shows does not help that block."""
    late = recorded("late", duration_s=40.0, extra=lambda t, k, d: np.where(t >= 32.0, 40e-6, 0.0))
    found, _ = _left_out(whole, [late])
    before, after = (m.total[DISPLACEMENT] / m.samples[DISPLACEMENT] for m in (found.before, found.after))
    assert int(np.argmax(before)) == BLOCKS - 1
    assert after[-1] == pytest.approx(before[-1], rel=0.1)
    assert before[-1] == pytest.approx(101.0, rel=0.1)  # (40 µm / 4 µm)² and the noise


def test_refits_without_an_effect_are_made_once(whole: Model, drifting: Callable[..., list[Run]]) -> None:
    runs = drifting(RATE, RATE)
    labels: list[str] = []
    stage, with_it = _stage(whole, runs)
    left_out = DataLeftOut(JudgedRuns.of(runs), JudgedRuns.of([]), lambda label, *_: labels.append(label))
    left_out.errors(stage, with_it, "one")
    labels.clear()
    left_out.errors(stage, optimum(with_effect(stage.fit.problem, DRIFT), "", silent, 1), "two")
    assert not any("as it is" in label for label in labels)
    assert any("with two" in label for label in labels)


def test_what_differs_takes_the_value_of_the_run_held_out(whole: Model, recorded: Callable[..., Run]) -> None:
    def stronger_and_drifting(t: np.ndarray, k: np.ndarray, d: np.ndarray) -> np.ndarray:
        return 0.03 * d + 4.0 * RATE * t

    train = [recorded(f"run {i}", seed=i, duration_s=40.0, extra=lambda t, k, d: 4.0 * RATE * t) for i in range(2)]
    test = recorded("held out", seed=2, duration_s=40.0, extra=stronger_and_drifting)
    stage, with_it = _stage(whole, train)
    left_out = DataLeftOut(JudgedRuns.of(train), JudgedRuns.of([test]), silent)
    assert left_out.on_test_runs(stage, stage.fit.problem.model, with_it.model) is None
    varies = {"stretch_law.alpha": Variation()}
    models = stage.fit.problem.model.varying(varies), with_it.model.varying(varies)
    found = left_out.on_test_runs(stage, *models)
    assert found is not None and found.names == ("held out",)
    assert JudgedRuns.of([test]).misfit(models[1]).rms[DISPLACEMENT] > 10.0  # with the value of all
    assert found.before.rms[DISPLACEMENT] > 4.0
    assert found.after.rms[DISPLACEMENT] < 1.5
