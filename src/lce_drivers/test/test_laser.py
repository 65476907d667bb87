# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from lce_drivers.laser.power_guard import PowerGuard, PowerLimits, State

LIMITS = PowerLimits(max_power_w=2.0, command_timeout_s=0.1)


def after(power_w: float, limits: PowerLimits = LIMITS) -> tuple[float, State]:
    guard = PowerGuard(limits)
    guard.command(power_w, 1.0, 1.0)
    return guard.power_w(1.01, 1.01), guard.state


def test_zero_before_the_first_command() -> None:
    guard = PowerGuard(LIMITS)
    assert guard.power_w(5.0, 5.0) == 0.0
    assert guard.state is State.WAITING


def test_a_fresh_command_within_the_limits_is_followed() -> None:
    assert after(1.25) == (1.25, State.FOLLOWING)
    assert after(0.0) == (0.0, State.FOLLOWING)
    assert after(2.0) == (2.0, State.FOLLOWING)


def test_a_command_above_the_limit_is_limited() -> None:
    assert after(7.0) == (2.0, State.LIMITED)


@pytest.mark.parametrize("command", [math.nan, math.inf, -math.inf, -1e-9, -1.0])
def test_what_is_not_a_power_gives_zero(command: float) -> None:
    assert after(command) == (0.0, State.INVALID)


def test_an_invalid_command_is_a_fault() -> None:
    guard = PowerGuard(LIMITS)
    guard.command(1.0, 0.0, 0.0)
    assert guard.power_w(0.01, 0.01) == 1.0 and guard.fault(0.01) is None
    guard.command(math.nan, 0.012, 0.012)
    assert guard.power_w(0.02, 0.02) == 0.0 and "not a power" in str(guard.fault(0.02))
    assert guard.invalid_commands == 1


@pytest.mark.parametrize(("power_w", "sent_s", "told"), [(math.nan, 1.0, "not a power"), (1.0, 61.0, "in the future")])
def test_an_invalid_command_is_told_at_once_though_another_follows_in_the_same_tick(
    power_w: float, sent_s: float, told: str
) -> None:
    guard = PowerGuard(LIMITS)
    assert told in str(guard.command(power_w, sent_s, 1.0))
    assert guard.command(1.0, 1.001, 1.001) is None


def test_a_slow_commander_is_heard_and_one_that_left_is_not() -> None:
    guard = PowerGuard(LIMITS)
    assert not guard.heard(0.0)
    guard.command(1.0, 1.0, 1.0)
    guard.power_w(1.01, 1.01)
    assert guard.heard(1.39) and not guard.heard(1.41)


def test_a_commander_that_ended_with_zero_has_abandoned_the_laser() -> None:
    guard = PowerGuard(LIMITS)
    assert not guard.abandoned(9.0), "there was none"
    guard.command(0.0, 1.0, 1.0)
    guard.power_w(1.01, 1.01)
    assert not guard.abandoned(1.3)
    assert guard.abandoned(1.6) and guard.fault(1.6) is None


def test_a_laser_that_is_armed_and_that_nobody_commands_is_abandoned_after_a_minute() -> None:
    guard = PowerGuard(LIMITS)
    guard.command(0.0, 1.0, 1.0)
    guard.forget(2.0)
    assert not guard.abandoned(61.9)
    assert guard.abandoned(62.1)
    guard.command(0.0, 62.0, 62.0)
    guard.power_w(62.1, 62.1)
    assert not guard.abandoned(62.1)


def test_a_command_of_exactly_the_time_out_still_counts_and_an_older_one_does_not() -> None:
    guard = PowerGuard(LIMITS)
    guard.command(1.0, 1.0, 1.0)
    assert guard.power_w(1.1, 1.1) == 1.0
    assert guard.power_w(1.11, 1.11) == 0.0
    assert guard.state is State.STALE


def test_a_late_tick_sees_the_true_age_of_the_command() -> None:
    guard = PowerGuard(LIMITS)
    guard.command(1.0, 1.0, 1.0)
    assert guard.power_w(1.05, 1.25) == 0.0


def test_a_command_of_the_same_instant_waits_for_the_next_tick() -> None:
    guard = PowerGuard(LIMITS)
    guard.command(1.0, 1.0, 1.0)
    assert guard.power_w(1.0, 1.0) == 0.0
    assert guard.power_w(1.01, 1.01) == 1.0


def test_a_rise_is_slewed_and_a_fall_is_not() -> None:
    guard = PowerGuard(PowerLimits(2.0, slew_w_per_s=10.0))
    powers = []
    for k in range(8):
        guard.command(0.25 if k < 5 else 0.05, k * 0.01, k * 0.01)
        powers.append(guard.power_w((k + 1) * 0.01, (k + 1) * 0.01))
    assert np.allclose(powers, [0.0, 0.1, 0.2, 0.25, 0.25, 0.05, 0.05, 0.05])


def test_who_commands_light_has_to_say_when_it_ends() -> None:
    for command, fault in ((1.0, "no command for 0.5 s after one of 1 W"), (0.0, None)):
        guard = PowerGuard(LIMITS)
        guard.command(command, 1.0, 1.0)
        for k in range(1, 51):
            guard.power_w(1.0 + 0.01 * k, 1.0 + 0.01 * k)
            assert guard.fault(1.0 + 0.01 * k) is None, "a short silence is a pause"
        guard.power_w(1.52, 1.52)
        assert guard.fault(1.52) == fault
        guard.forget(0.0)
        assert guard.power_w(1.53, 1.53) == 0.0 and guard.fault(1.53) is None


def test_a_command_from_the_future_gives_zero_for_nobody_knows_its_age() -> None:
    guard = PowerGuard(LIMITS)
    guard.command(1.0, 1.004, now_s=1.0)
    assert guard.power_w(1.01, 1.01) == 1.0, "a few ms are none"
    guard.command(1.0, 1.026, now_s=1.02)
    assert guard.power_w(1.03, 1.03) == 0.0 and guard.state is State.AHEAD and guard.invalid_commands == 1
    assert guard.power_w(9.0, 9.0) == 0.0, "nor when its time has come"


def test_a_slow_commander_commands_for_as_long_as_its_silence_is_no_fault() -> None:
    guard = PowerGuard(LIMITS)
    assert guard.commanded_w(1.0) == 0.0
    guard.command(1.5, 1.0, 1.0)
    until_s = 1.0 + LIMITS.fault_after_s
    assert guard.commanded_w(1.0) == guard.commanded_w(1.2) == guard.commanded_w(until_s - 0.01) == 1.5
    assert guard.commanded_w(until_s + 0.01) == 0.0
    guard.command(0.0, 1.2, 1.2)
    assert guard.commanded_w(1.2) == 0.0
    guard.command(math.nan, 1.2, 1.2)
    assert guard.commanded_w(1.2) == 0.0


def test_limits_can_be_changed_while_the_laser_shines() -> None:
    guard = PowerGuard(LIMITS)
    guard.command(1.5, 0.0, 0.0)
    assert guard.power_w(0.01, 0.01) == 1.5
    guard.limits = PowerLimits(1.0)
    assert guard.power_w(0.02, 0.02) == 1.0


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((-1.0,), "max_power_w"),
        ((math.nan,), "max_power_w"),
        ((1.0, 0.0), "command_timeout_s"),
        ((1.0, 0.1, math.inf), "slew"),
        ((1.0, 0.1, 0.0, 0.1), "fault_after_s"),
    ],
)
def test_limits_that_are_none_are_refused(arguments: tuple[float, ...], name: str) -> None:
    with pytest.raises(ValueError, match=name):
        PowerLimits(*arguments)


@pytest.mark.parametrize("seed", range(40))
def test_whatever_is_commanded_the_power_is_finite_and_within_limits(seed: int) -> None:
    """Random streams of sense and nonsense, with silences, leaps of time and live changes of the limits."""
    random = np.random.default_rng(seed)
    nonsense = [math.nan, math.inf, -math.inf, -1.0, 1e308, -0.0, 5e-324, 3.0]
    guard = PowerGuard(LIMITS)
    now, last, last_s, newest = 100.0, 0.0, 100.0, -math.inf
    for _ in range(500):
        if random.random() < 0.02:
            guard.limits = PowerLimits(*random.uniform([0.0, 0.02, 0.0], [5.0, 0.3, 50.0]))
        for _ in range(random.integers(0, 3)):
            command = random.choice(nonsense) if random.random() < 0.3 else random.uniform(0.0, 4.0)
            newest = now
            guard.command(float(command), now, now)
        now += random.choice([0.001, 0.01, 0.01, 0.01, 0.2, 3.0])
        power = guard.power_w(now, now)
        assert math.isfinite(power) and 0.0 <= power <= guard.limits.max_power_w
        if now - newest > guard.limits.command_timeout_s + 1e-6:
            assert power == 0.0
        if guard.limits.slew_w_per_s > 0.0:
            assert power <= last + guard.limits.slew_w_per_s * (now - last_s) + 1e-12
        last, last_s = power, now
