# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from lce_drivers.laser.interlock import Interlock, TemperatureLimits

LIMITS = TemperatureLimits(max_temperature_k=390.0)


def warm(until_s: float = 1.0) -> Interlock:
    """An interlock that has seen 10 Hz of 320 K."""
    lock = Interlock(LIMITS)
    for k in range(round(until_s * 10) + 1):
        lock.read(320.0, 0.1 * k)
    return lock


def test_light_is_permitted_while_readings_are_fresh() -> None:
    lock = warm()
    assert lock.permits(1.0, 0.5) and lock.permits(1.2, 0.5)
    assert not lock.permits(1.21, 0.5)
    lock.read(320.0, 1.25)
    assert lock.permits(1.3, 0.5) and lock.fault is None


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
    lock = Interlock(LIMITS)
    assert lock.permits(100.0, None) and not lock.permits(100.01, 0.5)
    assert not lock.permits(100.2, 0.5) and lock.fault is None
    assert not lock.permits(100.4, 0.5) and lock.fault is not None


def test_a_camera_that_dies_is_a_fault_also_while_zero_is_commanded() -> None:
    lock = warm()
    assert all(lock.permits(0.01 * k, 0.0) for k in range(100, 150)) and lock.fault is None
    assert not lock.permits(1.53, 0.0) and lock.fault is not None


def test_a_camera_that_is_yet_to_come_is_none_while_zero_is_commanded() -> None:
    lock = Interlock(LIMITS)
    assert all(lock.permits(0.01 * k, 0.0) for k in range(1000))


def test_a_bench_that_nobody_commands_needs_no_camera() -> None:
    lock = warm()
    assert all(lock.permits(t, None) for t in np.arange(1.0, 100.0, 0.1))
    assert lock.fault is None


@pytest.mark.parametrize(
    ("reading", "said"),
    [(390.1, "0.1 K above"), (math.nan, "nan"), (math.inf, "inf"), (-math.inf, "-inf"), (331.0, "jumped by 11.0 K"),
     (309.0, "jumped by 11.0 K")],
)  # fmt: skip
def test_what_no_sound_strip_shows_is_a_fault_that_stays(reading: float, said: str) -> None:
    lock = warm()
    lock.read(reading, 1.1)
    assert lock.fault is not None and said in lock.fault
    for k in range(100):
        lock.read(320.0, 1.2 + 0.1 * k)
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


def test_the_same_frame_again_is_not_fresh_and_a_frame_from_the_future_is_none() -> None:
    lock = warm()
    for k in range(10):
        lock.read(320.0, 1.0)
        assert lock.permits(1.0 + 0.1 * k, 0.5) == (k <= 2)
    lock.read(320.0, 10.0)
    assert not lock.permits(2.0, 0.5)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [((math.nan,), "max_temperature_k"), ((390.0, 0.0), "max_jump_k"), ((390.0, 10.0, 0.5, 0.5), "pause_after_s")],
)
def test_limits_that_are_none_are_refused(arguments: tuple[float, ...], name: str) -> None:
    with pytest.raises(ValueError, match=name):
        TemperatureLimits(*arguments)


@pytest.mark.parametrize("seed", range(20))
def test_whatever_is_read_light_needs_a_sound_fresh_temperature_and_no_fault(seed: int) -> None:
    random = np.random.default_rng(seed)
    lock, now, last = Interlock(LIMITS), 0.0, None
    for _ in range(1000):
        now += random.choice([0.01, 0.05, 0.3])
        if random.random() < 0.6:
            last = (float(random.choice([320.0, 320.5, 321.0, 391.0, math.nan], p=[0.33, 0.33, 0.32, 0.01, 0.01])), now)
            lock.read(*last)
        if random.random() < 0.02:
            lock.reset(now)
        if lock.permits(now, 0.5):
            assert last is not None and last[0] < 390.0 and now - last[1] <= 0.2 + 1e-9 and lock.fault is None
