# SPDX-License-Identifier: Apache-2.0
"""The loops closed over the simulated strip: pure, no noise."""

import numpy as np
import pytest

from lce_control.cascade import Cascade, Loop, OuterLoop
from lce_control.filters import Sample
from lce_control.pid import Gains, Limits
from lce_control.tuning.closed_loop import Controller, Sensors, run
from lce_model import default_model
from lce_model.inverse import InverseChart

POWER = Limits(0.0, 2.0)
SETPOINT = Limits(290.0, 370.0)
TARGET_M = 1.5e-3
STRIP = default_model("lumped", "dynamic")
IDEAL = Sensors(distance_noise_m=0.0, camera_noise_k=0.0)


def closed(control: Controller, duration_s: float, settings: dict[str, float] | None = None) -> np.ndarray:
    """Displacement [m] at 100 Hz under a controller that sees it, and a temperature at 10 Hz, 30 ms old."""
    return run(STRIP.set(settings or {}), control, duration_s, IDEAL).displacement_m


def cascade(follow_k: float = 2.0) -> Cascade:
    outer = OuterLoop(Loop.of(Gains(kp=3000.0, ki=3000.0), SETPOINT), follow_k)
    return Cascade(outer, Loop.of(Gains(kp=0.5, ki=0.1), POWER))


def test_the_cascade_reaches_the_target_and_stays() -> None:
    loops = cascade()
    feedforward_k = InverseChart(STRIP).temperature_k(TARGET_M)
    d = closed(lambda t, d, shot: loops.step(t, TARGET_M, feedforward_k, d, shot), 60.0)
    np.testing.assert_allclose(d[3000:], TARGET_M, rtol=0.01)
    assert d.max() < 1.05 * TARGET_M
    assert loops.setpoint_k == pytest.approx(InverseChart(STRIP).temperature_k(TARGET_M, "heating"), abs=0.5)


def test_the_outer_loop_corrects_a_strip_that_is_not_the_model() -> None:
    loops = cascade()
    feedforward_k = InverseChart(STRIP).temperature_k(TARGET_M)
    d = closed(lambda t, d, shot: loops.step(t, TARGET_M, feedforward_k, d, shot), 60.0, {"strip.length": 0.009})
    np.testing.assert_allclose(d[4000:], TARGET_M, rtol=0.01)


def test_the_outer_integral_rests_while_the_strip_is_on_its_way() -> None:
    feedforward_k = InverseChart(STRIP).temperature_k(TARGET_M)
    overshoot = []
    for follow_k in (2.0, np.inf):
        loops = cascade(follow_k)

        def control(t: float, d: Sample, shot: Sample, loops: Cascade = loops) -> float:
            return loops.step(t, TARGET_M, feedforward_k, d, shot)

        d = closed(control, 30.0)
        overshoot.append(d.max() / TARGET_M - 1.0)
    assert overshoot[0] < 0.05 < overshoot[1]


def test_the_single_loop_reaches_the_target_too() -> None:
    loop = Loop.of(Gains(kp=2000.0, ki=200.0), POWER)
    d = closed(lambda t, d, _: loop.step(t, TARGET_M, d), 90.0)
    np.testing.assert_allclose(d[6000:], TARGET_M, rtol=0.02)


def test_after_a_reset_a_cascade_is_as_new() -> None:
    loops = cascade()
    first = [loops.step(0.01 * k, TARGET_M, 320.0, Sample(0.0, 0.01 * k), Sample(301.0, 0.0)) for k in range(100)]
    loops.reset()
    again = [loops.step(0.01 * k, TARGET_M, 320.0, Sample(0.0, 0.01 * k), Sample(301.0, 0.0)) for k in range(100)]
    assert first == again
