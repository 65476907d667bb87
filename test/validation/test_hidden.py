# SPDX-License-Identifier: Apache-2.0
"""A small fixed part of the hidden-effect suite (`make hidden` runs it all), and the strip that it is made of."""

import numpy as np
import pytest
from strip import HIDDEN, OUTSIDE, STRENGTH, Body, measure
from suite import Case, gates, judge

from lce_model.effects import library

QUIET = np.random.default_rng(3)
BODY = Body.random(np.random.default_rng(1))
PULSE = np.concatenate([np.full(2000, 2.0), np.zeros(3000)])


def _seen(hidden: dict[str, float], power: np.ndarray = PULSE) -> tuple[np.ndarray, np.ndarray]:
    return measure(BODY, power, hidden, np.random.default_rng(5), 20.0)


def test_all_effects_of_the_library_can_be_hidden_and_three_that_it_does_not_know() -> None:
    assert set(HIDDEN) == set(library()) | set(OUTSIDE)
    assert len(OUTSIDE) == 3


def test_the_strip_heats_as_a_first_order_body_does_and_noise_is_as_large_as_it_says() -> None:
    camera, distance = _seen({})
    time = np.arange(camera.size) / 10.0
    # The power of a sample is held from there to the next one.
    on = BODY.ambient + 2.0 * BODY.gain * (1.0 - np.exp(-np.maximum(time - 0.0, 0.0) / BODY.tau))
    off = (on[200] - BODY.ambient) * np.exp(-(time - 20.0) / BODY.tau) + BODY.ambient
    exact = np.where(time <= 20.0, on, off)
    assert 0.04 < np.std(camera - exact) < 0.08
    assert abs(np.mean(camera - exact)) < 0.02
    assert 2.0e-3 < distance.max() < 3.5e-3


@pytest.mark.parametrize("name", HIDDEN)
def test_everything_hidden_changes_what_is_measured(name: str) -> None:
    plain, hidden = _seen({}), _seen({name: STRENGTH[name][1]})
    changed = [np.sqrt(np.mean((a - b) ** 2)) for a, b in zip(plain, hidden, strict=True)]
    assert changed[0] > 0.02 or changed[1] > 2e-6


@pytest.mark.slow
@pytest.mark.timeout(300)  # twenty seconds on a machine to itself
@pytest.mark.parametrize(
    ("hidden", "seed", "verdict"),
    [((), 0, "adequate"), (("laser_droop",), 0, "missing")],
)
def test_the_diagnosis_of_a_strip_that_the_product_has_never_seen(
    hidden: tuple[str, ...], seed: int, verdict: str
) -> None:
    result = judge(Case(hidden, "clear", seed))
    assert result["verdict"] == verdict
    if verdict == "missing":
        assert result["added"][0] == hidden[0]
        assert result["held_out"] < 0.83  # within 1.3 of the noise
    if verdict == "adequate":
        assert result["added"] == []


def test_the_gates_count_what_they_say() -> None:
    case = {"hidden": ["creep"], "misfit": 3.0, "verdict": "missing", "added": ["creep"], "held_out": 0.1}
    wrong = case | {"added": ["backlash"], "sets": [["backlash", "creep"]]}
    found = {name: passed for name, passed, _ in gates([case | {"sets": [["creep"]]}, wrong])}
    assert found["visible effect: named first"] == [True, False]
    assert found["visible effect: in the reported set"] == [True, True]
