# SPDX-License-Identifier: Apache-2.0
"""The predictive check: nine samples in ten are inside where the model is right, and where it is not, that is named."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import lfilter

import lce_analysis as lce
from lce_analysis.comparison.predictive_check import PredictiveCheck, as_json, predictive_check
from lce_analysis.comparison.sensor_process import SensorProcess, sensor_process
from lce_analysis.identification import FitResult, fit
from lce_analysis.identification.parameter_draws import draw_variables
from lce_analysis.identification.standing import standing_problems
from lce_analysis.identification.uncertainty import calibrated
from lce_analysis.options import CompareOptions
from lce_data.channels import DISPLACEMENT, SENSORS, TEMPERATURE
from lce_data.errors import LceError
from lce_data.progress import Cancelled, CancelToken
from lce_data.run import Run, Series
from lce_model import Model, Variation, default_model, simulate

STRIP = default_model("lumped", "equilibrium").set({"lumped.tau": 16.0, "lumped.gain": 33.0})
TIME = np.arange(0.0, 90.0, 0.01)
SIGMA = {TEMPERATURE: 0.06, DISPLACEMENT: 4e-6}


def noise(random: np.random.Generator, size: int, phi: float) -> np.ndarray:
    """Autoregressive noise of variance 1."""
    white = np.sqrt(1.0 - phi**2) * random.standard_normal(size + 500)
    return np.asarray(lfilter([1.0], [1.0, -phi], white)[500:])


def recorded(strip: Model, seed: int, phi: float = 0.0) -> Run:
    """90 s of steps of the light, then darkness."""
    random = np.random.default_rng(seed)
    levels = random.uniform(0.3, 2.0, 9)
    levels[0] = levels[-2:] = 0.0
    power = np.repeat(levels, TIME.size // 9)
    out = simulate(strip, TIME, power)
    slow = TIME[::10]
    warm = out.measured_temperature_k[::10] + SIGMA[TEMPERATURE] * noise(random, slow.size, phi)
    moved = out.measured_displacement_m + SIGMA[DISPLACEMENT] * noise(random, TIME.size, phi)
    return Run.of(f"steps{seed}", Series(TIME, power), Series(slow, warm), Series(TIME, moved), sha256=f"{seed} {phi}")


@cache
def fitted(phi: float = 0.0) -> tuple[FitResult, tuple[Run, ...]]:
    runs = tuple(recorded(STRIP, seed, phi) for seed in (1, 2, 3))
    return fit(default_model("lumped", "equilibrium"), runs), runs


@cache
def checked(phi: float = 0.0) -> PredictiveCheck:
    result, runs = fitted(phi)
    return predictive_check(result.model, runs)


@pytest.mark.parametrize("phi", [0.0, 0.5])
def test_of_a_model_that_is_right_nine_samples_in_ten_are_inside(phi: float) -> None:
    found = checked(phi)
    for check in found.channels.values():
        assert check.inside == pytest.approx(0.9, abs=0.03)
        assert check.as_expected
        assert all(inside == pytest.approx(0.9, abs=0.05) for inside in check.runs.values())
        quantiles = [r.outside for r in check.regimes]
        assert len(quantiles) > 10 and np.mean(quantiles) < 0.6
    assert all("if the model were right" in sentence for sentence in found.sentences)


def test_runs_that_the_model_was_not_fitted_to_are_as_well_predicted() -> None:
    result, runs = fitted()
    new = [recorded(STRIP, seed) for seed in (11, 12)]
    found = predictive_check(result.model, new, runs, draws=60)
    assert all(check.inside == pytest.approx(0.9, abs=0.03) for check in found.channels.values())
    assert list(found.channels[TEMPERATURE].runs) == ["steps11", "steps12"]


def test_a_camera_that_clips_is_found_and_where() -> None:
    clipped = STRIP.add("temperature_clip").set({"temperature_clip.inverse": 1.0 / 60.0})
    result, _ = fitted()
    found = predictive_check(result.model, [recorded(clipped, seed) for seed in (1, 2, 3)], draws=60)
    check = found.channels[TEMPERATURE]
    assert check.inside < 0.85 and not check.as_expected
    most = check.outside.most
    worst = max(check.regimes, key=lambda r: 1.0 - r.inside)
    assert worst.outside and worst.inside < 0.2
    assert most.lower_c - 1.0 <= worst.lower_c and most.upper_c > worst.lower_c
    assert f"between {most.lower_c:.0f} and {most.upper_c:.0f} °C" in found.sentences[0]
    assert found.channels[DISPLACEMENT].as_expected


def test_a_branch_that_is_wrong_is_named() -> None:
    result, runs = fitted()
    key = "equilibrium.t_star_c"
    found = predictive_check(result.model.set({key: result.model[key] + 0.5}), runs, draws=60)
    assert found.channels[TEMPERATURE].as_expected
    assert found.channels[DISPLACEMENT].inside < 0.87
    assert found.sentences[1].startswith("Inside the 90% band: ") and "while cooling" in found.sentences[1]


def test_a_run_that_is_unlike_the_others_is_named() -> None:
    result, runs = fitted()
    odd = recorded(STRIP.set({"lumped.gain": 33.5}), 4)
    found = predictive_check(result.model, [*runs, odd], runs, draws=60)
    assert "; fewest in steps4, " in found.sentences[0]


def test_rooms_that_differ_from_run_to_run() -> None:
    rooms = {"a": 299.0, "b": 301.0, "c": 303.0}
    runs = [
        replace(recorded(STRIP.set({"ambient.t_env": t_env}), seed), name=name)
        for seed, (name, t_env) in enumerate(rooms.items())
    ]
    model = default_model("lumped", "equilibrium").varying({"ambient.t_env": Variation()})
    model = fit(model, runs).model
    for found in (
        predictive_check(model, runs, draws=60),
        predictive_check(model, runs[2:], fitted_to=runs[:2], draws=60),
    ):
        assert all(check.inside == pytest.approx(0.9, abs=0.03) for check in found.channels.values())


def test_draws_have_the_standard_errors_of_the_fit() -> None:
    result, _ = fitted()
    problem = result.problem
    variables = draw_variables(calibrated(problem), 400, 0)
    values = problem.split(variables)[0]
    known = [j for j, i in enumerate(problem.free) if result.model.values[i].determined]
    assert len(known) > 6
    for j in known:
        error = result.model.values[problem.free[j]].standard_error
        assert error is not None
        assert np.std(values[:, j]) == pytest.approx(error, rel=0.25)


def test_what_the_data_do_not_determine_does_not_spoil_the_predictions() -> None:
    """Below its transition a strip says nothing of most of its parameters."""
    cold = STRIP.set({"lumped.gain": 2.0})
    runs = [recorded(cold, seed) for seed in (1, 2)]
    found = predictive_check(cold, runs, draws=60)
    for check in found.channels.values():
        assert check.inside == pytest.approx(0.9, abs=0.03)
        assert max(float(np.max(r.high - r.low)) for r in check.regimes) < SIGMA[check.channel]


def test_the_measured_temperature_may_drive() -> None:
    result, runs = fitted()
    heat, deformation = standing_problems(result.model, runs, "measured")
    assert {s.channel for s in heat.observed} == {TEMPERATURE}
    assert {s.channel for s in deformation.observed} == {DISPLACEMENT}
    assert not set(heat.free) & set(deformation.free)
    wrong = result.model.set({"lumped.tau": 20.0})
    found = predictive_check(wrong, runs, draws=40, options=CompareOptions(drive="measured"))
    assert found.channels[TEMPERATURE].inside < 0.5
    assert found.channels[DISPLACEMENT].inside > 0.8


def test_a_problem_stands_where_the_fit_ended() -> None:
    result, runs = fitted()
    (problem,) = standing_problems(result.model, runs)
    assert problem.free == result.problem.free
    np.testing.assert_allclose(problem.first(), result.problem.first(), atol=1e-6)


def test_the_same_seed_gives_the_same_and_another_one_another() -> None:
    result, runs = fitted()
    a, b, c = (as_json(predictive_check(result.model, runs[:1], draws=20, seed=seed)) for seed in (1, 1, 2))
    assert a == b != c
    assert json.loads(json.dumps(a, allow_nan=False)) == a
    assert {channel.name for channel in SENSORS} < set(a)


def test_too_few_draws_and_a_cancelled_check() -> None:
    result, runs = fitted()
    with pytest.raises(LceError, match="5 simulations are too few, 20 or more make a band"):
        lce.predictive_check(result.model, runs, draws=5)
    cancel = CancelToken()
    cancel.cancel()
    with pytest.raises(Cancelled):
        lce.predictive_check(result.model, runs, cancel=cancel)


@pytest.mark.parametrize("phi", [0.0, 0.6])
def test_noise_that_is_drawn_is_like_the_noise_of_the_sensor(phi: float) -> None:
    random = np.random.default_rng(3)
    time_s = np.arange(20_000) / 100.0
    made = [0.5 * noise(random, time_s.size, phi) for _ in range(3)]
    found = sensor_process([Series(time_s, np.sin(time_s) + n) for n in made], [n + 2.0 * time_s / 200.0 for n in made])
    drawn = found.draw(random, 20, 2000)
    assert np.std(drawn) == pytest.approx(0.5, rel=0.08)
    assert np.mean(drawn[:, 1:] * drawn[:, :-1]) / np.var(drawn) == pytest.approx(phi, abs=0.12)


def test_a_series_of_few_samples_has_white_noise() -> None:
    time_s = np.arange(60) / 10.0
    value = np.random.default_rng(0).standard_normal(60)
    assert sensor_process([Series(time_s, value)], [value]).coefficients.size == 0
    assert SensorProcess(np.empty(0), 2.0).draw(np.random.default_rng(0), 3, 5).shape == (3, 5)
