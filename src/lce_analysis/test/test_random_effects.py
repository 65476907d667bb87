# SPDX-License-Identifier: Apache-2.0
"""Parameters that differ from run to run, in fits and diagnoses, on a heater that is made here alone."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.signal import lsim, lti

from lce_analysis.diagnosis import diagnose
from lce_analysis.identification import fit
from lce_analysis.identification.homogeneity import differing
from lce_analysis.prediction import ambient_at_rest, predict
from lce_data.channels import TEMPERATURE
from lce_data.errors import LceError
from lce_data.run import Run, Series
from lce_model import Model, Variation, default_model
from lce_model.effects import find

NOISE_K = 0.05
GAIN, TAU_S, SECOND_S = 30.0, 20.0, 6.0
LUMPED = default_model("lumped", "none")
CANDIDATES = [find(name) for name in ("second_mass", "radiation", "ambient_drift", "laser_saturation")]


def heater(name: str, seed: int, ambient_k: float = 295.0, gain: float = GAIN, second_s: float = 0.0) -> Run:
    """A minute of random powers at 10 Hz, five seconds of darkness before; one pole, or two."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, 65.0, 0.1)
    power_w = np.repeat(np.concatenate([np.zeros(1), rng.uniform(0.2, 1.0, 12)]), 50)
    poles = [-1.0 / TAU_S, *([-1.0 / second_s] if second_s else [])]
    rise = lsim(lti([], poles, gain * np.prod(np.abs(poles))), power_w, time_s, interp=False)[1]
    value = ambient_k + rise + NOISE_K * rng.standard_normal(time_s.size)
    return Run.of(name, Series(time_s, power_w), Series(time_s, value), sha256=f"{name}/{seed}")


AMBIENTS_K = (292.0, 294.0, 295.5, 297.0, 299.0)


@pytest.fixture(scope="module")
def days() -> list[Run]:
    """Five days with another ambient temperature each."""
    return [heater(f"day {i}", i, ambient) for i, ambient in enumerate(AMBIENTS_K)]


def varying(*keys: str) -> Model:
    """The lumped model in which parameters differ from run to run."""
    return LUMPED.varying({key: Variation() for key in keys})


def test_the_value_of_each_run_is_found_with_its_error(days: Sequence[Run]) -> None:
    model = fit(varying("ambient.t_env"), days).model
    variation = model.varies["ambient.t_env"]
    for run, ambient in zip(days, AMBIENTS_K, strict=True):
        own = variation.by_run[run.name]
        assert own.standard_error is not None
        assert abs(own.value - ambient) < 4.0 * own.standard_error < 0.1
    assert variation.spread == pytest.approx(float(np.std(AMBIENTS_K, ddof=1)), rel=0.1)
    assert model["lumped.tau"] == pytest.approx(TAU_S, rel=0.01)


def test_a_run_that_says_little_is_drawn_towards_the_others() -> None:
    runs = [heater(f"day {i}", i, gain=GAIN * (1.0 + 0.02 * (i - 2))) for i in range(5)]
    clean = runs[0].temperature
    assert clean is not None
    noise_k = 5.0 * np.random.default_rng(9).standard_normal(clean.value.size)
    runs[0] = runs[0].with_series(TEMPERATURE, Series(clean.time_s, clean.value + noise_k))
    alone = fit(LUMPED.fix(["ambient.t_env"]).set({"ambient.t_env": 295.0}), runs[:1]).model["lumped.gain"]
    model = fit(varying("lumped.gain").fix(["ambient.t_env"]).set({"ambient.t_env": 295.0}), runs).model
    own = model.varies["lumped.gain"].by_run["day 0"].value
    assert abs(own - model["lumped.gain"]) < abs(alone - model["lumped.gain"])


def test_another_run_takes_its_ambient_temperature_from_its_samples_at_rest(days: Sequence[Run]) -> None:
    model = fit(varying("ambient.t_env"), days).model
    run = heater("another day", 9, 301.0)
    assert run.temperature is not None
    residual = predict(model, run).at_samples[TEMPERATURE] - run.temperature.value
    assert np.sqrt(np.mean(residual**2)) < 1.2 * NOISE_K


def test_a_run_that_cools_before_the_laser_is_on_does_not_show_its_ambient_temperature() -> None:
    run = heater("warm", 0)
    assert run.temperature is not None
    cooling = 20.0 * np.exp(-run.temperature.time_s / TAU_S)
    warm = run.with_series(TEMPERATURE, Series(run.temperature.time_s, run.temperature.value + cooling))
    assert ambient_at_rest(warm) is None
    assert ambient_at_rest(run) == pytest.approx(295.0, abs=0.1)


def test_a_fit_says_that_one_value_does_not_serve_all_runs(days: Sequence[Run]) -> None:
    (sentence,) = differing(fit(LUMPED, days).problem)
    assert "one value of ambient.t_env does not serve all runs" in sentence
    assert "--varies ambient.t_env" in sentence
    assert differing(fit(LUMPED, [heater(f"day {i}", i) for i in range(5)]).problem) == ()


def test_an_ambient_temperature_that_differs_is_found_and_nothing_else(days: Sequence[Run]) -> None:
    found = diagnose(fit(LUMPED, days).model, days, effects=CANDIDATES)
    assert [step.key for step in found.variations] == ["ambient.t_env"]
    assert (found.verdict, found.steps) == ("adequate", ())
    assert any(sentence.startswith("ambient.t_env (") for sentence in found.sentences)
    values = found.as_json()["varies"]["ambient.t_env"]
    assert [values[run.name][0] for run in days] == pytest.approx(AMBIENTS_K, abs=0.1)


def test_where_nothing_differs_nothing_is_said_to() -> None:
    runs = [heater(f"day {i}", i) for i in range(5)]
    found = diagnose(fit(LUMPED, runs).model, runs, effects=CANDIDATES)
    assert (found.verdict, found.variations, found.as_json()["varies"]) == ("adequate", (), {})


def test_a_second_mass_is_found_beside_a_gain_that_differs() -> None:
    runs = [heater(f"day {i}", i, gain=GAIN * (1.0 + 0.04 * (i - 2)), second_s=SECOND_S) for i in range(5)]
    found = diagnose(fit(LUMPED, runs).model, runs, effects=CANDIDATES)
    assert [step.added for step in found.steps] == ["second_mass"]
    assert [step.key for step in found.variations] == ["lumped.gain"]


def test_a_parameter_that_the_model_lacks_is_named() -> None:
    with pytest.raises(LceError, match=r"unknown parameter 'lumped\.tao'"):
        varying("lumped.tao")
