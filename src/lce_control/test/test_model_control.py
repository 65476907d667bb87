# SPDX-License-Identifier: Apache-2.0
"""The model-based controller and its observer on the simulated strip: pure, with the sensors' noise."""

import math
from pathlib import Path

import numba.core.event
import numpy as np
import pytest

from lce_control.filters import Sample
from lce_control.model_control import ModelController
from lce_control.observer import Observer
from lce_control.step_metrics import step_metrics
from lce_control.time_optimal import fastest_power_w
from lce_control.tuning.bang_bang import bang_bang
from lce_control.tuning.closed_loop import Sensors, run
from lce_model import Stepper, default_model

STRIP = default_model("lumped", "kinetic").set({"lumped.gain": 73.0, "stretch_law.alpha": 2.2})


def test_a_strip_whose_displacement_is_no_number_gets_no_light() -> None:
    class Strip:
        temperature_k, displacement_m = 300.0, math.nan

        def copy(self) -> "Strip":
            return self

        def step(self, power_w: float, duration_s: float) -> None:
            pass

    assert fastest_power_w(Strip(), 1e-3, 0.1, 2.0) == 0.0  # type: ignore[arg-type]


def test_nothing_is_compiled_once_there_is_a_controller(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LCE_CACHE_DIR", str(tmp_path))  # what comes from the cache would not be seen
    control = ModelController(STRIP.add("radiation").add("laser_droop"))
    compiled = numba.core.event.RecordingListener()
    with numba.core.event.install_listener("numba:compile", compiled):
        assert control.step(0.0, 1.0e-3, Sample(0.0, 0.0), Sample(301.15, 0.0)) > 0.0
    assert not compiled.buffer


@pytest.mark.parametrize("target_m", [1.0e-3, 3.0e-3])
def test_a_target_is_reached_as_fast_as_can_be_and_held(target_m: float) -> None:
    control = ModelController(STRIP)
    loop = run(STRIP, lambda t, d, shot: control.step(t, target_m, d, shot), 40.0, seed=1)
    best = bang_bang(STRIP, target_m, 10.0)
    figures = step_metrics(loop.time_s, loop.displacement_m, target_m)
    assert figures.rise_time_s <= 1.05 * step_metrics(best.time_s, best.displacement_m, target_m).rise_time_s
    assert figures.overshoot < 0.005 and figures.rmse_after_30s < 0.002


def test_steps_down_and_minor_loops_are_led_on_their_branch() -> None:
    control, targets_m = ModelController(STRIP), (2.5e-3, 1.0e-3, 1.5e-3)
    loop = run(STRIP, lambda t, d, shot: control.step(t, targets_m[int(t // 30.0)], d, shot), 90.0, seed=2)
    for k, target_m in enumerate(targets_m):
        late = loop.displacement_m[3000 * k + 2500 : 3000 * (k + 1)]
        assert np.abs(late / target_m - 1.0).max() < 0.005


def test_the_strip_is_not_led_beyond_its_temperature() -> None:
    control = ModelController(STRIP, hottest_k=335.0)
    loop = run(STRIP, lambda t, d, shot: control.step(t, 3.0e-3, d, shot), 20.0, seed=3)
    assert 334.5 < loop.temperature_k.max() < 335.5


@pytest.mark.parametrize(
    "changes",
    [{"lumped.gain": 0.8 * 73.0}, {"ambient.t_env": 296.15}, {"lumped.gain": 0.75 * 73.0, "lumped.tau": 0.75 * 18.0}],
    ids=["less power", "colder", "draught"],
)
def test_what_the_heat_balance_does_not_know_does_not_move_the_strip(changes: dict[str, float]) -> None:
    control = ModelController(STRIP)
    loop = run(
        STRIP,
        lambda t, d, shot: control.step(t, 2.0e-3, d, shot),
        40.0,
        seed=4,
        changes=[(15.0, STRIP.set(changes))],
    )
    assert np.abs(loop.displacement_m[1000:] / 2.0e-3 - 1.0).max() < 0.01


def test_a_weak_laser_is_told_from_a_drift() -> None:
    strip, weak = Stepper(STRIP, 301.15), Observer(STRIP, 301.15)
    random = np.random.default_rng(5)
    for k in range(1, 3000):
        power_w = 0.5 if k // 300 % 2 else 0.1
        strip.step(0.8 * power_w, 0.01)
        weak.advance(power_w, 0.01 * k, 0.01)
        if k % 10 == 0:
            weak.see_temperature(Sample(strip.temperature_k + 0.06 * random.standard_normal(), 0.01 * k))
    assert weak.strip.gain == pytest.approx(0.8, abs=0.05)
    assert weak.strip.drift_k_s == pytest.approx(0.0, abs=0.06)
    assert weak.strip.temperature_k == pytest.approx(strip.temperature_k, abs=0.1)


def test_an_image_is_compared_with_the_temperature_of_its_time() -> None:
    fresh, late = Observer(STRIP, 301.15), Observer(STRIP, 301.15)
    strip = Stepper(STRIP, 301.15)
    shots = []
    for k in range(1, 301):
        strip.step(2.0, 0.01)
        shots.append(Sample(strip.temperature_k, 0.01 * k))
        for observer in (fresh, late):
            observer.advance(2.0, 0.01 * k, 0.01)
        if k % 10 == 0:
            fresh.see_temperature(shots[-1])
            late.see_temperature(shots[-4] if k > 10 else shots[0])
    for observer in (fresh, late):
        assert observer.strip.temperature_k == pytest.approx(strip.temperature_k, abs=0.01)
        assert observer.strip.gain == pytest.approx(1.0, abs=0.001)


def test_before_the_first_image_there_is_no_light_and_after_a_clock_set_back_all_begins_anew() -> None:
    control = ModelController(STRIP)
    control.observe(1.0, Sample(0.0, 1.0), None)
    assert control.power_w(2.0e-3) == 0.0
    control.observe(1.1, Sample(0.0, 1.1), Sample(320.0, 1.1))
    assert control.power_w(2.0e-3) > 0.0
    control.observe(0.5, None, None)
    assert control.observer is None and control.power_w(2.0e-3) == 0.0
    assert math.isfinite(control.step(0.6, 2.0e-3, Sample(0.0, 0.6), Sample(301.15, 0.6)))


def test_a_ramp_is_followed_without_lag() -> None:
    control = ModelController(STRIP)

    def target_m(t: float) -> float:
        return 1.0e-3 + 1.0e-4 * min(max(t - 10.0, 0.0), 10.0)

    loop = run(STRIP, lambda t, d, shot: control.step(t, target_m(t), d, shot), 20.0, Sensors(), seed=6)
    error_m = loop.displacement_m - np.array([target_m(t) for t in loop.time_s])
    assert np.abs(error_m[1200:]).max() < 10e-6
