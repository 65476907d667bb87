# SPDX-License-Identifier: Apache-2.0
import math

from lce_ros.timed_value import TimedValue


def test_a_value_counts_from_the_instant_after_it_was_received() -> None:
    value: TimedValue[str] = TimedValue()
    value.put("a", 1.0)
    assert value.get(1.0) is None
    assert value.get(1.01) == "a"


def test_the_newest_of_the_earlier_values_is_taken() -> None:
    value: TimedValue[int] = TimedValue()
    for i in range(5):
        value.put(i, i * 0.01)
    assert value.get(0.03) == 2
    assert value.get(0.05) == 4


def test_a_value_stays_and_ages() -> None:
    value: TimedValue[int] = TimedValue()
    assert value.age(5.0) == math.inf
    value.put(7, 1.0)
    assert value.get(3.0) == 7
    assert value.age(3.0) == 2.0


def test_the_order_of_arrival_within_a_tick_does_not_matter() -> None:
    early: TimedValue[int] = TimedValue()
    late: TimedValue[int] = TimedValue()
    seen: list[tuple[int | None, int | None]] = []
    for k in range(10):
        early.put(k, k * 0.01)
        seen.append((early.get(k * 0.01), late.get(k * 0.01)))
        late.put(k, k * 0.01)
    assert all(a == b for a, b in seen)
    assert seen[-1] == (8, 8)


def test_time_that_falls_forgets_every_value() -> None:
    value: TimedValue[int] = TimedValue()
    value.put(1, 10.0)
    assert value.get(11.0) == 1
    value.put(2, 0.5)
    assert value.get(0.5) is None
    assert value.get(0.6) == 2


def test_what_waits_is_bounded_and_the_newest_survives() -> None:
    value: TimedValue[int] = TimedValue(limit=3)
    for i in range(100):
        value.put(i, float(i))
    assert value.get(1000.0) == 99
