# SPDX-License-Identifier: Apache-2.0
"""`make control`: its cases and reference controllers, and that every mode meets its bars with control.yaml's gains."""

import numpy as np
import pytest
import yaml
from control_cases import MODES, controller, known, play, steps, trajectory
from reference_controllers import DoubleLoop, SingleLoop

from lce_control.cascade import Loop, OuterLoop
from lce_control.filters import Sample
from lce_control.pid import Gains, Limits
from lce_control.step_metrics import step_metrics
from lce_control.tuning.closed_loop import run
from lce_control.tuning.requirements import Requirements, check
from lce_control.tuning.tasks import INNER, OUTER, SINGLE, TuningPlant
from lce_experiment import config, registry
from lce_model import default_model
from lce_model.inverse import InverseChart, OutOfReach

STRIP = default_model("lumped", "kinetic").set({"lumped.gain": 73.0, "stretch_law.alpha": 2.2})
POWER_W = Limits(0.0, 2.0)


def test_a_case_has_its_targets_in_time() -> None:
    case = steps("two", (1.0, 2.0), hold_s=10.0)
    np.testing.assert_allclose(case.target_m(np.array([0.0, 9.99, 10.0, 19.0])), [1e-3, 1e-3, 2e-3, 2e-3])
    ramp = trajectory("ramp", lambda t: 1e-3 + 1e-4 * t, 2.0)
    np.testing.assert_allclose(ramp.target_m(np.array([0.0, 0.39, 1.99])), [1e-3, 1.036e-3, 1.196e-3])


def test_every_mode_of_the_bench_is_compared() -> None:
    assert set(MODES) == set(registry.CONTROLLERS)
    for mode in MODES:
        controller(mode, known())


@pytest.mark.parametrize("target_mm", [1.0, 2.5])
def test_by_the_model_the_bars_are_met(target_mm: float) -> None:
    case = steps("one", (target_mm,), hold_s=40.0)
    best, loop = play(case, "limit", 0), play(case, "model", 1)
    limit, figures = (step_metrics(x.time_s, x.displacement_m, 1e-3 * target_mm) for x in (best, loop))
    assert figures.rise_time_s <= 1.3 * limit.rise_time_s
    assert figures.overshoot <= 0.01 and figures.rmse_after_30s <= 0.005


@pytest.mark.parametrize("mode", ["single", "double"])
def test_with_the_gains_of_control_yaml_the_bars_are_met(mode: str) -> None:
    figures = []
    for target_mm in (1.0, 3.0):
        loop = play(steps("one", (target_mm,)), mode, 1)
        figures.append(step_metrics(loop.time_s, loop.displacement_m, 1e-3 * target_mm))
    assert max(f.overshoot for f in figures) <= 0.05 and max(f.rmse_after_30s for f in figures) <= 0.01
    assert max(f.rise_time_s for f in figures) <= 5.2, "full power all the way takes 5.1 s to 80 % of 3 mm"


def test_the_gains_of_control_yaml_are_those_of_the_default_strip() -> None:
    """They meet what `lce tune` requires of them there."""
    content = yaml.safe_load(config.config_file("control.yaml").read_text(encoding="utf-8"))
    gains = {node: content[f"/**/{node}"]["ros__parameters"] for node in (INNER, OUTER, SINGLE)}
    plant, wanted = TuningPlant.of(known(), config.laser_limit_w()), Requirements()
    double, single = plant.double().tuned(gains), plant.single().tuned(gains)
    check(double, wanted)
    check(single, wanted)


def test_a_strip_that_is_not_the_model_is_held_all_the_same() -> None:
    case = steps("off", (2.0,), hold_s=40.0, settings={"kinetic.barrier": 0.9 * known()["kinetic.barrier"]})
    loop = play(case, "model", 1)
    assert step_metrics(loop.time_s, loop.displacement_m, 2e-3).rmse_after_30s < 0.005


def double() -> DoubleLoop:
    outer = OuterLoop(Loop.of(Gains(kp=0.0), Limits(273.15, 383.15)))
    return DoubleLoop(STRIP, outer, Loop.of(Gains(kp=1.0, ki=0.1), POWER_W))


def test_the_feed_forward_is_that_of_the_branch_that_the_strip_is_on() -> None:
    loops, targets_m = double(), (1.0e-3, 2.5e-3, 1.0e-3)
    setpoints_k = []

    def control(t_s: float, displacement: Sample, temperature: Sample) -> float:
        power_w = loops.step(t_s, targets_m[int(t_s // 20.0)], displacement, temperature)
        setpoints_k.append(loops.cascade.setpoint_k)
        return power_w

    loop = run(STRIP, control, 60.0)
    chart = InverseChart(STRIP)
    assert setpoints_k[0] == pytest.approx(chart.temperature_k(1.0e-3, "heating"), abs=1.0)
    assert setpoints_k[-1] == pytest.approx(chart.temperature_k(1.0e-3, "cooling"), abs=3.0)
    assert loop.temperature_k[-1] == pytest.approx(setpoints_k[-1], abs=0.5)


def test_a_target_out_of_reach_is_refused() -> None:
    with pytest.raises(OutOfReach):
        double().step(0.0, 9e-3, Sample(0.0, 0.0), Sample(301.15, 0.0))


def test_the_single_loop_does_not_look_at_the_temperature() -> None:
    powers = []
    for kelvin in (301.15, 400.0):
        single = SingleLoop(Loop.of(Gains(kp=1000.0), POWER_W))
        powers.append([single.step(0.01 * k, 1e-3, Sample(0.0, 0.01 * k), Sample(kelvin, 0.0)) for k in range(9)])
    assert powers[0] == powers[1] and np.allclose(powers[0], 1.0)
