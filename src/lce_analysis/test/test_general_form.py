# SPDX-License-Identifier: Apache-2.0
"""A free curve in the place of an effect says whether the effect has the form of what is missing."""

import numpy as np
import pytest

from lce_analysis import DiagnoseOptions, diagnose
from lce_analysis.diagnosis.chain import Chain
from lce_analysis.diagnosis.general_form import GeneralForm, general_form, refitted_with_curve
from lce_data.channels import TEMPERATURE
from lce_data.progress import silent
from lce_data.run import Run, Series
from lce_model import default_model
from lce_model.effects import find, library

HEATER = default_model("lumped", "none")
AMBIENT_K = 296.0


def convecting(name: str, seed: int, share: float = 0.9) -> Run:
    """A run of 80 s whose loss grows with the power 1.25 of the excess over the surroundings, in steps of 1 ms."""
    time = np.arange(0.0, 80.0, 0.1)
    rng = np.random.default_rng(seed)
    power = np.where(time % 40.0 > 4.0, rng.choice([0.4, 0.9, 1.6, 2.2], 2)[(time // 40.0).astype(int)], 0.1)
    kelvin = [AMBIENT_K]
    for watt in power[:-1]:
        now = kelvin[-1]
        for _ in range(100):
            excess = now - AMBIENT_K
            factor = 1.0 - share + share * (max(excess, 1e-9) / 40.0) ** 0.25
            now += 1e-3 * (40.0 * watt - factor * excess) / 12.0
        kelvin.append(now)
    noise = 0.03 * rng.standard_normal(time.size)
    return Run.of(name, Series(time, power), Series(time, np.array(kelvin) + noise), sha256=name)


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    return [convecting(f"day-{i}", i) for i in range(4)]


@pytest.mark.parametrize(
    ("effect", "place", "quantity"),
    [
        ("radiation", "heat", "temperature"),
        ("natural_convection", "heat", "temperature"),
        ("laser_saturation", "light", "power"),
        ("thermal_expansion", "strain", "temperature"),
        ("elastic_softening", "strain", "temperature"),
        ("temperature_clip", "temperature_sensor", "temperature"),
        ("displacement_step", "displacement_sensor", "time"),
    ],
)
def test_an_effect_of_one_quantity_is_a_curve_over_it(effect: str, place: str, quantity: str) -> None:
    assert general_form(find(effect)) == GeneralForm(place, quantity)


@pytest.mark.parametrize(
    "effect",
    ["clamp_conduction", "creep", "camera_lag", "load_shift", "load_stretch", "latent_heat", "loss_step"],
)
def test_what_remembers_or_depends_on_something_else_is_no_curve(effect: str) -> None:
    assert general_form(find(effect)) is None


@pytest.mark.parametrize("effect", ["ambient_drift", "displacement_drift"])
def test_a_drift_has_no_form_of_its_own(effect: str) -> None:
    assert general_form(find(effect)) is None


def test_a_curve_explains_what_a_loss_of_another_form_leaves(runs: list[Run]) -> None:
    options, form = DiagnoseOptions(), GeneralForm("heat", "temperature")
    radiating = Chain(HEATER.add(find("radiation")), runs, (), (), options, silent).present
    assert not radiating.heat[0].explained(options)
    curve = refitted_with_curve(radiating.heat[0], form, options, silent)
    assert curve is not None and curve.mean_squares[TEMPERATURE] < 1.05**2


def test_a_curve_explains_no_more_beside_the_true_effect(runs: list[Run]) -> None:
    options, form = DiagnoseOptions(), GeneralForm("heat", "temperature")
    true = Chain(HEATER.add(find("natural_convection")), runs, (), (), options, silent).present
    curve = refitted_with_curve(true.heat[0], form, options, silent)
    assert curve is not None
    gained = true.mean_squares[TEMPERATURE] - curve.mean_squares[TEMPERATURE]
    assert 0.0 < gained < options.worth_noise


def test_a_curve_over_what_the_runs_do_not_show_is_none(runs: list[Run]) -> None:
    present = Chain(HEATER, runs, (), (), DiagnoseOptions(), silent).present
    assert refitted_with_curve(present.heat[0], GeneralForm("heat", "order"), DiagnoseOptions(), silent) is None


def test_an_effect_of_another_form_is_not_named_and_the_true_one_is(runs: list[Run]) -> None:
    test = [convecting("held-out", 9)]
    found = diagnose(HEATER, runs, test)
    assert found.as_json()["added"] == ["natural_convection"]
    without = diagnose(HEATER, runs, test, [e for e in library().values() if e.name != "natural_convection"])
    assert without.as_json()["added"] == []
    (like_it,) = (c.trial for c in without.candidates if c.effect.name == "radiation")
    assert like_it is not None and like_it.objection == "form"
    assert "radiation" in "".join(s for s in without.sentences if "`lce discover`" in s)
