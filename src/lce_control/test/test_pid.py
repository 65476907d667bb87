# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim

from lce_control.filters import Sample
from lce_control.pid import PID, Gains, Limits

WIDE = Limits(-1e9, 1e9)
GAINS = Gains(kp=0.05, ki=0.01, kd=0.001)
"""(6.11)"""


def outputs(pid: PID, times: np.ndarray, setpoints: np.ndarray, measured: np.ndarray) -> np.ndarray:
    rows = zip(times, setpoints, measured, strict=True)
    return np.array([pid.step(t, r, Sample(y, t)) for t, r, y in rows])


def test_without_limits_it_is_the_controller_of_6_2() -> None:
    random = np.random.default_rng(1)
    times = 0.01 * np.arange(300)
    setpoint, measured = random.normal(size=(2, 300))
    setpoint[0] = measured[0]
    gains = Gains(kp=2.0, ki=3.0, kd=0.1, n=50.0, derivative_weight=1.0)
    kp, ki, kd, n = gains.kp, gains.ki, gains.kd, gains.n
    numerator = [kp + kd * n, kp * n + ki, ki * n]
    _, exact, _ = lsim((numerator, [1.0, n, 0.0]), setpoint - measured, times)
    np.testing.assert_allclose(outputs(PID(gains, WIDE), times, setpoint, measured), exact, atol=1e-9)


def test_the_output_does_not_depend_on_the_steps_in_time() -> None:
    """Error and measured value run straight; the derivative filter has long settled."""
    random = np.random.default_rng(2)
    ends = []
    for _ in range(5):
        times = np.concatenate([[0.0], np.sort(random.uniform(0.0, 10.0, 100)), [10.0]])
        ends.append(outputs(PID(GAINS, WIDE), times, 5.0 + 0.5 * times, 0.3 * times)[-1])
    np.testing.assert_allclose(ends, ends[0], rtol=1e-9)
    assert ends[0] == pytest.approx(0.05 * 7.0 + 0.01 * (5.0 * 10.0 + 0.2 * 50.0) - 0.001 * 0.3)


def test_the_integral_stops_at_the_limit_and_comes_back_at_once() -> None:
    pid = PID(Gains(kp=1.0, ki=1.0), Limits(0.0, 2.0))
    times = 0.01 * np.arange(1000)
    assert outputs(pid, times, np.full(1000, 1.5), np.zeros(1000))[-1] == 2.0
    assert pid.limited == 1 and pid.i == pytest.approx(0.5)
    back = pid.step(10.0, 1.5, Sample(1.6, 10.0))
    assert back == pytest.approx(-0.1 + 0.5, abs=0.01) and pid.limited == 0


def test_an_output_that_starts_beyond_a_limit_gathers_nothing() -> None:
    for setpoint, limited in ((50.0, 1), (-50.0, -1)):
        pid = PID(Gains(kp=1.0, ki=1.0), Limits(0.0, 2.0))
        outputs(pid, 0.01 * np.arange(500), np.full(500, setpoint), np.zeros(500))
        assert pid.i == 0.0 and pid.limited == limited


@pytest.mark.parametrize("seed", range(10))
def test_whatever_happens_the_output_is_within_the_limits_and_the_integral_never_pushed_it_out(seed: int) -> None:
    random = np.random.default_rng(seed)
    pid = PID(Gains(*random.uniform(0.01, 3.0, 3)), Limits(-0.5, 2.0), horizon_s=random.uniform(0.0, 0.5))
    t_s, sample = 0.0, Sample(0.0, 0.0)
    for _ in range(2000):
        t_s += random.choice([0.0, 0.001, 0.01, 0.3])
        if random.random() < 0.3:
            sample = Sample(random.normal(), t_s)
        if random.random() < 0.01:
            pid.gains = Gains(*random.uniform(0.01, 3.0, 3))
        before = pid.i
        feedforward = random.normal()
        assert -0.5 <= pid.step(t_s, random.normal(), sample, feedforward) <= 2.0
        rest = feedforward + pid.p + pid.d
        assert not (pid.i > before and rest + pid.i > 2.0 + 1e-9)
        assert not (pid.i < before and rest + pid.i < -0.5 - 1e-9)


def test_new_gains_do_not_move_the_output() -> None:
    pid = PID(GAINS, Limits(0.0, 2.0))
    times = 0.01 * np.arange(500)
    before = outputs(pid, times, np.full(500, 20.0), 3.0 * np.sin(times))[-1]
    now = Sample(3.0 * np.sin(times[-1]), times[-1])
    for gains in (Gains(0.3, 0.2, 0.05, 10.0), Gains(0.0, 0.1), GAINS):
        pid.gains = gains
        assert pid.step(times[-1], 20.0, now) == pytest.approx(before, abs=1e-12)


def test_a_reset_begins_at_the_output_it_is_given() -> None:
    pid = PID(GAINS, Limits(0.0, 2.0))
    pid.step(0.0, 30.0, Sample(20.0, 0.0))
    pid.reset(1.25)
    assert pid.step(9.0, 30.0, Sample(28.0, 9.0), feedforward=0.3) == pytest.approx(1.25)
    pid.reset()
    assert pid.step(9.5, 30.0, Sample(28.0, 9.5)) == pytest.approx(0.05 * 2.0)


def test_held_samples_of_a_camera_give_what_a_camera_without_delay_would() -> None:
    """10 Hz, 30 ms late, read at 100 Hz: the output is that of the true temperature, and does not jump."""
    gains = Gains(kp=0.5, ki=0.05, kd=0.2)
    ideal, held = PID(gains, WIDE), PID(gains, WIDE)
    times = 0.01 * np.arange(1000)
    truth = 3.0 * times - 0.05 * times**2
    difference, steps, last = [], [], None
    for t, y in zip(times, truth, strict=True):
        measured_s = max(0.0, np.floor((t - 0.03) * 10.0 + 1e-6) / 10.0)
        u = held.step(t, 40.0, Sample(3.0 * measured_s - 0.05 * measured_s**2, measured_s))
        difference.append(u - ideal.step(t, 40.0, Sample(y, t)))
        steps.append(0.0 if last is None else abs(u - last))
        last = u
    assert np.abs(difference[50:]).max() < 0.015, "W, of a slope of 1.5 W/s"
    assert max(steps[50:]) < 0.03, "W; the slope alone makes 0.015"


def test_a_held_sample_is_no_kick_of_the_derivative() -> None:
    pid = PID(Gains(kp=0.0, kd=1.0), WIDE)
    terms = []
    for k in range(200):
        measured_s = k // 10 * 0.1
        pid.step(0.01 * k, 0.0, Sample(2.0 * measured_s, measured_s))
        terms.append(pid.d)
    np.testing.assert_allclose(terms[20:], -2.0, atol=1e-3)


def test_a_step_of_the_setpoint_kicks_only_where_it_is_told_to() -> None:
    for weight, kick in ((0.0, 0.0), (1.0, 50.0)):
        pid = PID(Gains(kp=0.0, kd=1.0, derivative_weight=weight), WIDE)
        pid.step(0.0, 0.0, Sample(0.0, 0.0))
        assert pid.step(0.01, 1.0, Sample(0.0, 0.01)) == pytest.approx(kick * 2.0 * (1.0 - np.exp(-1.0)))


def test_an_integral_that_is_held_stays() -> None:
    pid = PID(Gains(kp=1.0, ki=1.0), WIDE)
    for k in range(100):
        pid.step(0.01 * k, 1.0, Sample(0.0, 0.01 * k), integrate=k >= 50)
    assert pid.i == pytest.approx(0.5)


def test_a_time_that_falls_begins_anew() -> None:
    pid = PID(GAINS, WIDE)
    for k in range(100):
        pid.step(100.0 + k, 30.0, Sample(20.0, 100.0 + k))
    assert pid.step(1.0, 30.0, Sample(20.0, 1.0)) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("change", "name"),
    [({"kp": -1.0}, "kp"), ({"ki": np.inf}, "ki"), ({"kd": np.nan}, "kd"), ({"n": 0.0}, "n"),
     ({"setpoint_weight": 1.5}, "setpoint_weight")],
)  # fmt: skip
def test_gains_that_are_none_are_refused(change: dict[str, float], name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        replace(GAINS, **change)


@pytest.mark.parametrize("limits", [(1.0, 0.0), (0.0, np.inf), (np.nan, 1.0)])
def test_limits_that_are_none_are_refused(limits: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="not a finite range"):
        Limits(*limits)
