# SPDX-License-Identifier: Apache-2.0
"""The loops with their feed-forward, closed over the simulated strip."""

import numpy as np
import pytest

from lce_control.filters import Sample
from lce_control.followers import DoubleLoop, SingleLoop
from lce_control.loops import Loop, OuterLoop
from lce_control.pid import Gains, Limits
from lce_control.tuning.closed_loop import run
from lce_model import default_model
from lce_model.inverse import InverseChart, OutOfReach

STRIP = default_model("lumped", "kinetic").set({"lumped.gain": 73.0, "stretch_law.alpha": 2.2})
POWER = Limits(0.0, 2.0)


def double() -> DoubleLoop:
    outer = OuterLoop(Loop.of(Gains(kp=0.0), Limits(273.15, 383.15)))
    return DoubleLoop(STRIP, outer, Loop.of(Gains(kp=1.0, ki=0.1), POWER))


def test_the_feed_forward_is_that_of_the_branch_that_the_strip_is_on() -> None:
    follower, targets_m = double(), (1.0e-3, 2.5e-3, 1.0e-3)
    setpoints_k = []

    def control(t_s: float, displacement: Sample, temperature: Sample) -> float:
        power_w = follower.step(t_s, targets_m[int(t_s // 20.0)], displacement, temperature)
        setpoints_k.append(follower.cascade.setpoint_k)
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
        follower = SingleLoop(Loop.of(Gains(kp=1000.0), POWER))
        powers.append([follower.step(0.01 * k, 1e-3, Sample(0.0, 0.01 * k), Sample(kelvin, 0.0)) for k in range(9)])
    assert powers[0] == powers[1] and np.allclose(powers[0], 1.0)
