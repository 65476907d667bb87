# SPDX-License-Identifier: Apache-2.0
"""Profiles and bands: what they say of data whose truth is known."""

import numpy as np
import pytest

from lce_analysis.identification import FitResult, fit
from lce_analysis.identification.profile import Profile, profiles
from lce_analysis.identification.uncertainty import band
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

TRUTH = {"lumped.gain": 32.0, "lumped.tau": 15.0, "ambient.t_env": 300.0}
TIME = np.arange(0.0, 60.0, 0.05)
POWER = np.where(TIME < 25.0, 1.5 + 0.3 * np.sin(TIME / 4.0), 0.0)


def quiet(label: str, done: int, total: int, rms: float) -> None:
    """No progress shown."""


def recorded(model: Model, seed: int, name: str = "run") -> Run:
    """A run of the model with white noise."""
    out, random = simulate(model, TIME, POWER), np.random.default_rng(seed)
    warm = Series(TIME[::2], out.temperature_k[::2] + 0.06 * random.standard_normal(TIME[::2].size))
    moved = None
    if model.deformation != "none":
        moved = Series(TIME, out.displacement_m + 4e-6 * random.standard_normal(TIME.size))
    return Run.of(name, Series(TIME, POWER), warm, moved)


@pytest.fixture(scope="module")
def heated() -> FitResult:
    return fit(default_model("lumped", "none"), [recorded(default_model("lumped", "none").set(TRUTH), 0)])


def test_where_the_model_is_nearly_linear_the_profile_is_the_standard_error(heated: FitResult) -> None:
    found = {p.key: p for p in profiles(heated.problem, quiet)}
    assert set(found) == set(TRUTH)
    for key, p in found.items():
        error = heated.model.values[heated.model.index(key)].standard_error
        assert error is not None and p.low is not None and p.high is not None
        assert (p.high - p.low) / (2.0 * 1.96 * error) == pytest.approx(1.0, abs=0.15)
        assert p.low - error < TRUTH[key] < p.high + error
        assert np.all(np.diff(p.values) > 0.0)
        assert p.rise.min() == 0.0


def test_a_parameter_without_effect_has_an_open_profile() -> None:
    """Far below its transition a strip says nothing of the width of its loop, which does not reach down to it."""
    far = {"kinetic.t_c": 450.0, "kinetic.width_spread": 0.0}
    model = default_model("lumped", "kinetic").set({**TRUTH, "lumped.gain": 1.0, **far})
    keys = [v.key for v in model.values if v.key not in ("kinetic.half_width", "stretch_law.alpha")]
    narrow = model.fix(keys).hold({"kinetic.half_width": (0.05, 30.0)})
    result = fit(narrow, [recorded(model, 1)])
    by_key = {p.key: p for p in profiles(result.problem, quiet)}
    width = by_key["kinetic.half_width"]
    assert width.low is None and width.high is None
    assert width.sentence == "kinetic.half_width is not determined"
    assert by_key["stretch_law.alpha"].low is not None


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (None, 2.0, "a.b is at most 2 s"),
        (1.0, None, "a.b is at least 1 s"),
        (1.0, 2.0, "a.b is 1.5 s, between 1 and 2"),
    ],
)
def test_profiles_in_words(low: float | None, high: float | None, words: str) -> None:
    assert Profile("a.b", "s", 1.5, np.array([1.5]), np.array([0.0]), low, high).sentence == words


def test_the_band_is_as_wide_as_predictions_scatter(heated: FitResult) -> None:
    """The same experiment thirty times: the predictions scatter by the half-width of the band over 1.96."""
    truth = default_model("lumped", "none").set(TRUTH)
    unseen = recorded(truth, 99)
    found = band(heated.problem, unseen)
    predicted = []
    for seed in range(30):
        model = fit(truth, [recorded(truth, 100 + seed)]).model
        predicted.append(simulate(model, TIME, POWER).temperature_k)
    scatter = np.std(predicted, axis=0)[20:]
    ratio = found.error[TEMPERATURE][20:] / 1.96 / scatter
    assert 0.75 < np.sqrt(np.mean(ratio**2)) < 1.35
    assert found.error[DISPLACEMENT].size == TIME.size


def test_bands_of_the_displacement_follow_from_both_stages() -> None:
    model = default_model("lumped", "kinetic").set(TRUTH)
    result = fit(model, [recorded(model, 3, "a"), recorded(model, 4, "b")])
    found = band(result.problem, recorded(model, 5))
    off = np.abs(found.value[DISPLACEMENT] - simulate(model, TIME, POWER).displacement_m)
    assert 0.0 < found.error[DISPLACEMENT].max() < 5e-6
    assert np.mean(off <= 1.5 * found.error[DISPLACEMENT]) > 0.8
