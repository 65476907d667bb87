# SPDX-License-Identifier: Apache-2.0
"""Frequency responses of a strip and margins of its loops, against closed forms."""

import numpy as np
import pytest

from lce_control.pid import Gains
from lce_control.tuning.closed_loop import Sensors
from lce_control.tuning.linear import OMEGA, LinearPlant, margins
from lce_data.errors import LceError
from lce_model import default_model

STRIP = default_model("lumped", "kinetic")
GAIN, TAU_S = STRIP["lumped.gain"], STRIP["lumped.tau"]
PLANT = LinearPlant.of(STRIP, 0.8, (0.5e-3, 1.0e-3))


def test_the_response_of_a_lumped_strip_is_that_of_its_equation() -> None:
    expected = GAIN / (TAU_S * 1j * OMEGA + 1.0)
    np.testing.assert_allclose(PLANT.response, expected, rtol=0.02)
    assert pytest.approx(GAIN, rel=1e-6) == PLANT.gain_k_w
    assert pytest.approx(TAU_S, rel=0.01) == PLANT.tau_s


def test_margins_of_an_integrator_with_a_delay() -> None:
    delay_s, gain = 0.5, 1.0
    found = margins(gain / (1j * OMEGA) * np.exp(-1j * OMEGA * delay_s))
    assert found.gain == pytest.approx(0.5 * np.pi / (gain * delay_s), rel=1e-3)
    assert found.phase_deg == pytest.approx(90.0 - np.degrees(gain * delay_s), rel=1e-3)
    assert found.crossover_rad_s == pytest.approx(gain, rel=1e-3)


def test_a_loop_that_never_crosses_has_no_margin_to_lose() -> None:
    found = margins(0.1 / (1j * OMEGA + 1.0))
    assert np.isinf(found.gain) and np.isinf(found.phase_deg)


def test_a_loop_that_is_loud_to_the_end_has_no_margin() -> None:
    found = margins(np.full(OMEGA.size, 50.0 + 0.0j))
    assert found.gain == 0.0 and found.phase_deg == -180.0


def test_more_gain_is_less_margin_and_an_old_sample_costs_phase() -> None:
    soft, sharp = (margins(PLANT.inner(Gains(kp), 0.1, Sensors())) for kp in (0.5, 2.0))
    assert sharp.gain == pytest.approx(soft.gain / 4.0, rel=0.01)
    slow_camera = margins(PLANT.inner(Gains(2.0), 0.1, Sensors(camera_latency_s=0.2)))
    assert slow_camera.phase_deg < sharp.phase_deg - 5.0


def test_the_outer_loop_sees_the_closed_inner_one() -> None:
    outer = PLANT.outer(Gains(200.0), Gains(100.0), 0.0, Sensors(camera_latency_s=0.0, camera_period_s=0.01))
    assert outer[0] == pytest.approx(200.0 * PLANT.slope_m_k, rel=0.01), "an inner loop that follows is a gain of 1"


def test_over_an_inner_loop_too_soft_to_act_the_outer_one_is_the_single_loop() -> None:
    """An old image of the camera costs the outer loop nothing there: it is in the feedback of the inner one."""
    soft, outer = 1e-6, Gains(5e9, 1e9, 1e9, n=5.0)
    cascade = PLANT.outer(outer, Gains(soft), 0.1, Sensors(camera_latency_s=0.5))
    single = PLANT.single(Gains(soft * 5e9, soft * 1e9, soft * 1e9, n=5.0), 0.1)
    np.testing.assert_allclose(cascade, single, rtol=1e-3)


def test_a_strip_without_a_response_is_refused() -> None:
    dim = default_model("lumped", "kinetic", ("laser_saturation",)).set({"laser_saturation.p_th": 0.5})
    with pytest.raises(LceError, match="does not get warmer"):
        LinearPlant.of(dim, 0.2, (0.0, 1e-3))
