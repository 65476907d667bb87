# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from lce_drivers.laser.interlock import Interlock, TemperatureLimits
from lce_drivers.laser.power_guard import PowerGuard, PowerLimits

LIMITS = TemperatureLimits(max_temperature_k=390.0)


class Latched:
    """An interlock, and the first fault that it told."""

    def __init__(self, limits: TemperatureLimits = LIMITS) -> None:
        self.lock = Interlock(limits)
        self.fault: str | None = None

    def read(self, temperature_k: float, measured_s: float, now_s: float | None = None) -> None:
        fault = self.lock.read(temperature_k, measured_s, measured_s if now_s is None else now_s)
        self.fault = self.fault or fault

    def permits(self, now_s: float, power_w: float | None) -> bool:
        fault = self.lock.judge(now_s, power_w)
        self.fault = self.fault or fault
        return self.fault is None and (self.lock.is_fresh(now_s) or not (power_w is not None and power_w > 0.0))

    def reset(self, now_s: float) -> str | None:
        obstacle = self.lock.obstacle(now_s)
        self.fault = None if obstacle is None else self.fault
        return obstacle


def warm(until_s: float = 1.0) -> Latched:
    """An interlock that has seen 10 Hz of 320 K."""
    lock = Latched()
    for k in range(round(until_s * 10) + 1):
        lock.read(320.0 + 0.01 * (k % 2), 0.1 * k)
    return lock


def test_light_is_permitted_while_readings_are_fresh() -> None:
    lock = warm()
    assert lock.permits(1.0, 0.5) and lock.permits(1.2, 0.5)
    assert not lock.permits(1.21, 0.5)
    lock.read(320.0, 1.25)
    assert lock.permits(1.3, 0.5) and lock.fault is None


@pytest.mark.parametrize(
    ("every", "timeout_s"), [(1, 0.1), (13, 0.1), (20, 0.1), (40, 0.1), (25, 0.3), (10, 0.45), (70, 0.1)]
)
def test_a_silent_camera_is_a_fault_however_slow_the_commander_is(every: int, timeout_s: float) -> None:
    guard, lock = PowerGuard(PowerLimits(max_power_w=2.0, command_timeout_s=timeout_s)), warm()
    for k in range(100, 300):
        now_s = 0.01 * k
        if k % every == 0:
            guard.command(0.5, now_s - 0.001, now_s - 0.001)
        wanted_w = guard.power_w(now_s, now_s)
        lock.permits(now_s, wanted_w if guard.heard(now_s) else None)
    assert lock.fault == "no temperature for 0.5 s"


def test_a_temperature_from_before_the_newest_is_a_fault() -> None:
    lock = warm()
    lock.read(360.0, 0.95, 1.05)
    assert lock.fault == "a temperature is stamped 0.050 s before the one that came before it"
    lock.read(320.0, 1.1)
    assert lock.reset(1.1) is None


def test_a_pause_of_the_camera_becomes_a_fault_after_500_ms() -> None:
    lock = warm()
    permitted = {k: lock.permits(0.01 * k, 0.5) for k in range(100, 160)}
    assert [k for k, p in permitted.items() if p] == list(range(100, 121))
    assert lock.fault == "no temperature for 0.5 s"
    lock = warm()
    for k in range(100, 150):
        lock.permits(0.01 * k, 0.5)
    assert lock.fault is None


def test_without_any_reading_there_is_no_light_and_soon_a_fault() -> None:
    lock = Latched()
    assert lock.permits(100.0, None) and not lock.permits(100.01, 0.5)
    assert not lock.permits(100.2, 0.5) and lock.fault is None
    assert not lock.permits(100.4, 0.5) and lock.fault is not None


def test_a_camera_that_dies_is_a_fault_also_while_zero_is_commanded() -> None:
    lock = warm()
    assert all(lock.permits(0.01 * k, 0.0) for k in range(100, 150)) and lock.fault is None
    assert not lock.permits(1.53, 0.0) and lock.fault is not None


def test_a_camera_that_is_yet_to_come_is_none_while_zero_is_commanded() -> None:
    lock = Latched()
    assert all(lock.permits(0.01 * k, 0.0) for k in range(1000))


def test_a_bench_that_nobody_commands_needs_no_camera() -> None:
    lock = warm()
    assert all(lock.permits(t, None) for t in np.arange(1.0, 100.0, 0.1))
    assert lock.fault is None


@pytest.mark.parametrize(
    ("reading", "said"),
    [(390.1, "0.1 K above"), (math.nan, "nan"), (math.inf, "inf"), (-math.inf, "-inf"), (331.0, "jumped by 11.0 K"),
     (309.0, "jumped by 11.0 K"), (233.05, "0.1 K below what the camera can measure"), (-26.85, "260.0 K below")],
)  # fmt: skip
def test_what_no_sound_strip_shows_is_a_fault_that_stays(reading: float, said: str) -> None:
    lock = warm()
    lock.read(reading, 1.1)
    assert lock.fault is not None and said in lock.fault
    for k in range(100):
        lock.read(320.0 + 0.01 * (k % 2), 1.2 + 0.1 * k)
        assert not lock.permits(1.2 + 0.1 * k, 0.5) and not lock.permits(1.2 + 0.1 * k, None)
    assert lock.reset(11.1) is None
    assert lock.fault is None and lock.permits(11.1, 0.5)


def test_a_fault_cannot_be_reset_while_its_cause_is_there() -> None:
    lock = warm()
    lock.read(395.0, 1.1)
    assert lock.reset(1.1) == "the strip is 5.0 K above its highest temperature"
    assert lock.reset(2.0) == "there is no fresh temperature"
    lock.read(math.nan, 2.0)
    assert lock.reset(2.0) == "the temperature is nan"
    assert lock.fault is not None and not lock.permits(2.0, 0.5)


def test_the_first_fault_is_the_one_that_is_told() -> None:
    lock = warm()
    lock.read(395.0, 1.1)
    first = lock.fault
    lock.read(300.0, 1.2)
    assert lock.fault == first


def test_a_strip_that_cooled_while_nobody_looked_has_not_jumped() -> None:
    lock = warm()
    lock.read(300.0, 60.0)
    assert lock.fault is None and lock.permits(60.0, 0.5)


def test_the_same_frame_again_is_not_fresh() -> None:
    lock = warm()
    for k in range(10):
        lock.read(320.0, 1.0, 1.0 + 0.1 * k)
        assert lock.permits(1.0 + 0.1 * k, 0.5) == (k <= 2)


def test_a_frame_from_the_future_is_none_and_the_fault_says_so() -> None:
    lock = warm()
    lock.read(320.0, 1.104, now_s=1.1)
    assert lock.permits(1.1, 0.5) and lock.permits(1.304, 0.5) and not lock.permits(1.31, 0.5), "a few ms are none"
    for ahead_s in (0.006, 0.2, 10.0):
        lock = warm()
        for k in range(1, 80):
            lock.read(320.0 + 0.01 * (k % 2), 1.0 + 0.01 * k + ahead_s, now_s=1.0 + 0.01 * k)
            assert lock.permits(1.0 + 0.01 * k, 0.5) == (k <= 20), ahead_s
        assert lock.fault == f"no temperature for 0.5 s; readings are stamped {ahead_s:.3f} s in the future"


def test_a_reading_that_stays_the_same_bit_for_bit_under_light_is_a_fault() -> None:
    lock = warm()
    for k in range(100):
        lock.read(321.0, 1.1 + 0.1 * k)
        assert lock.permits(1.1 + 0.1 * k, 0.0), "in the dark nothing has to move"
    lit = [lock.permits(11.1 + 0.1 * k, 0.5) for k in range(20) if lock.read(321.0, 11.1 + 0.1 * k) is None]
    assert sum(lit) == 10 and lock.fault == "the temperature has not changed for 1.0 s, as if frozen"
    assert "as if frozen" in str(lock.reset(13.0))
    lock.read(321.01, 13.1)
    assert lock.reset(13.1) is None


def test_light_in_pieces_does_not_hide_a_frozen_camera() -> None:
    lock = warm()
    lock.read(321.0, 1.05)
    lit = []
    for k in range(60):
        lock.read(321.0, 1.1 + 0.1 * k)
        lit.append(lock.permits(1.1 + 0.1 * k, 0.5 if k % 6 < 3 else 0.0) and k % 6 < 3)
    assert 9 <= sum(lit) <= 12 and "as if frozen" in str(lock.fault)


def test_noise_of_a_camera_in_steps_of_10_mk_is_never_taken_for_frozen() -> None:
    random, lock = np.random.default_rng(3), Latched()
    for k in range(100_000):
        lock.read(round(320.0 + 0.06 * random.standard_normal(), 2), 0.1 * k)
        lock.permits(0.1 * k, 0.5)
    assert lock.fault is None


def test_a_camera_without_noise_can_be_declared() -> None:
    lock = Latched(TemperatureLimits(max_temperature_k=390.0, frozen_after_s=0.0))
    for k in range(1000):
        lock.read(320.0, 0.1 * k)
        assert lock.permits(0.1 * k, 0.5)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ((math.nan,), "max_temperature_k"),
        ((390.0, 400.0), "min_temperature_k"),
        ((390.0, 233.0, 0.0), "max_jump_k"),
        ((390.0, 233.0, 10.0, 0.5, 0.5), "pause_after_s"),
        ((390.0, 233.0, 10.0, 0.2, 0.5, -1.0), "frozen_after_s"),
    ],
)
def test_limits_that_are_none_are_refused(arguments: tuple[float, ...], name: str) -> None:
    with pytest.raises(ValueError, match=name):
        TemperatureLimits(*arguments)


@pytest.mark.parametrize("seed", range(20))
def test_whatever_is_read_light_needs_a_sound_fresh_temperature_and_no_fault(seed: int) -> None:
    random = np.random.default_rng(seed)
    lock, now, last = Latched(), 0.0, None
    for _ in range(1000):
        now += random.choice([0.01, 0.05, 0.3])
        if random.random() < 0.6:
            last = (float(random.choice([320.0, 320.5, 321.0, 391.0, math.nan], p=[0.33, 0.33, 0.32, 0.01, 0.01])), now)
            lock.read(*last)
        if random.random() < 0.02:
            lock.reset(now)
        if lock.permits(now, 0.5):
            assert last is not None and last[0] < 390.0 and now - last[1] <= 0.2 + 1e-9
