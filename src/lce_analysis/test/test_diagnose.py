# SPDX-License-Identifier: Apache-2.0
"""Small campaigns with something hidden; how well the method does is measured in test/hidden."""

import numpy as np
import pytest

from lce_analysis.diagnosis import add_effect, diagnose
from lce_data.errors import LceError
from lce_data.run import Run, Series
from lce_data.waveforms import RATE_HZ, SHAPES
from lce_model import Model, default_model, simulate
from lce_model.effects import find

BASE = default_model("lumped", "equilibrium")
CANDIDATES = [find(name) for name in ("creep", "thermal_gradient", "ambient_drift", "displacement_drift")]
WAVES = {
    "pulse": ("pulse", {"amp": 0.8, "th": 16.0, "offset": 1.7, "rest": 30.0}),
    "stairs": ("stairs", {"low": 0.5, "high": 2.2, "steps": 4, "hold": 8.0, "rest": 20.0}),
    "prbs": ("prbs", {"low": 0.6, "high": 2.4, "bit": 4.0, "order": 4, "rest": 10.0}),
}


def _run(name: str, strip: Model, disturbed: float = 0.0, seed: int = 0) -> Run:
    """A run of the strip; ``disturbed`` is the share by which the laser breathes without the record showing it."""
    kind, options = WAVES[name]
    power = SHAPES[kind].power_w({k: (float(v),) for k, v in options.items()})
    time = np.arange(power.size) / RATE_HZ
    noise = np.random.default_rng((seed, len(name)))
    actual = power * (1.0 + disturbed * np.sin(2.0 * np.pi * time / 7.0 + noise.uniform(0.0, 6.0)))
    true = simulate(strip, time, actual)
    camera = slice(None, None, 10)
    temperature = true.measured_temperature_k[camera] + 0.06 * noise.standard_normal(time[camera].size)
    displacement = true.measured_displacement_m + 4e-6 * noise.standard_normal(time.size)
    series = Series(time, power), Series(time[camera], temperature), Series(time, displacement)
    return Run.of(name, *series, sha256=name)


def _campaign(strip: Model, **options: float) -> tuple[list[Run], list[Run]]:
    runs = [_run(name, strip, **options) for name in WAVES]
    return runs[:2], runs[2:]


def test_a_complete_model_is_adequate() -> None:
    found = diagnose(BASE, *_campaign(BASE), CANDIDATES)
    assert found.verdict == "adequate"
    assert found.steps == ()
    assert max(s.evidence for s in found.scores) < 12.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["creep", "thermal_gradient", "displacement_drift"])
def test_a_hidden_effect_is_named_and_the_held_out_error_comes_down_to_the_noise(name: str) -> None:
    effect = find(name)
    strip = BASE.add(name).set({effect.strength_key: effect.typical})
    train, test = _campaign(strip)
    found = diagnose(BASE, train, test, CANDIDATES)
    assert found.verdict == "missing"
    assert [s.added for s in found.steps] == [name]
    assert found.model[effect.strength_key] == pytest.approx(effect.typical, rel=0.15)
    noise = found.noise_floor["displacement_m"]
    assert test[0].displacement is not None
    assert found.error["test"]["after"]["displacement_nrmse"] < 1.2 * noise / np.std(test[0].displacement.value)


def test_what_no_effect_explains_is_called_unexplained() -> None:
    found = diagnose(BASE, *_campaign(BASE, disturbed=0.08), CANDIDATES)
    assert found.verdict == "unexplained"
    assert "temperature not predicted" in found.fingerprint


def test_the_record_has_every_key_of_the_contract() -> None:
    found = diagnose(BASE, *_campaign(BASE), CANDIDATES[:2])
    record = found.as_json()
    assert set(record) == {
        "verdict", "added", "steps", "candidates", "error", "noise_floor", "fingerprint", "seconds",
    }  # fmt: skip
    assert {c["effect"] for c in record["candidates"]} == {"creep", "thermal_gradient"}
    assert set(record["candidates"][0]) == {
        "effect", "stage", "evidence", "p_value", "visibility", "expected_strength", "predicted_fall", "aliases",
    }  # fmt: skip
    assert set(record["error"]) == {"train", "test"}
    assert record["noise_floor"]["temperature_c"] == pytest.approx(0.06, rel=0.1)
    detailed = found.as_detailed_json()
    assert {key: value for key, value in detailed.items() if key not in ("candidates", "sentences")} == {
        key: value for key, value in record.items() if key != "candidates"
    }
    assert detailed["sentences"] == list(found.sentences)
    for candidate, of_contract in zip(detailed["candidates"], record["candidates"], strict=True):
        assert {key: candidate.pop(key) for key in of_contract} == of_contract
        assert set(candidate) == {"settings", "shown"}
        for key, value in candidate["settings"].items():
            effect, _, name = key.partition(".")
            bounds = find(effect).parameter(name)
            assert bounds.lower <= value <= bounds.upper


def test_adding_an_effect_keeps_its_standard_error_and_the_history() -> None:
    strip = BASE.add("creep").set({"creep.share": 0.1, "creep.tau_v": 8.0})
    train, test = _campaign(strip)
    addition = add_effect(BASE, "creep", train, test)
    share = addition.model.values[addition.model.index("creep.share")]
    assert share.standard_error is not None
    assert abs(share.value - 0.1) < 5.0 * share.standard_error
    assert addition.confirmed
    assert 0.5 < addition.predicted_reduction < addition.actual_reduction + 0.1 < 1.1
    before, after = addition.model.fit["history"]
    assert after["effects"] == ["creep"]
    assert after["test"]["displacement_nrmse"] < 0.5 * before["test"]["displacement_nrmse"]
    with pytest.raises(LceError, match="has creep already"):
        add_effect(addition.model, "creep", train)


def test_an_effect_that_is_not_there_is_not_confirmed() -> None:
    assert not add_effect(BASE, "creep", *_campaign(BASE)).confirmed
