# SPDX-License-Identifier: Apache-2.0
import pytest

from lce_drivers.laser.clock_watch import ClockWatch, StallWatch


def verdicts(*ticks: int) -> list[bool]:
    """What a watch says when it finds these numbers of ticks at its checks."""
    watch = ClockWatch()
    return [watch.stopped(number) for number in ticks]


def test_a_clock_that_ticks_between_two_checks_runs() -> None:
    assert not any(verdicts(0, 10, 20, 30))


def test_a_clock_without_a_tick_for_two_checks_has_stopped() -> None:
    assert verdicts(10, 20, 20, 20) == [False, False, False, True]


def test_a_machine_that_stood_still_is_not_taken_for_a_clock_that_stopped() -> None:
    """Its late check is followed at once by the next, before the next tick."""
    assert not any(verdicts(10, 20, 21, 21, 31, 41, 41, 51))


def test_a_clock_that_stopped_before_its_first_tick_is_noticed() -> None:
    assert verdicts(0, 0, 0)[-1]


def test_a_gap_between_ticks_counts_where_it_began_with_light() -> None:
    watch = StallWatch(0.1)
    assert watch.tick(5.0, 5.0, lit=True) is None, "the first tick has none before it"
    assert watch.tick(5.1, 5.1, lit=True) is None
    assert watch.tick(5.31, 5.31, lit=True) == "the laser node stood still for 0.21 s with the light on"
    assert watch.tick(9.0, 9.0, lit=False) is None
    assert watch.tick(9.01, 9.01, lit=True) is None


@pytest.mark.parametrize(("step_s", "told"), [(60.0, "forward by 60.00 s"), (-0.5, "back by 0.50 s"), (0.05, None)])
def test_a_clock_that_is_set_counts_where_it_was_set_with_light(step_s: float, told: str | None) -> None:
    for lit in (False, True):
        watch = StallWatch(0.1)
        watch.tick(5.0, 105.0, lit=lit)
        fault = watch.tick(5.01, 105.01 + step_s, lit=lit)
        assert fault == (f"the clock was set {told} with the light on" if lit and told else None)
        assert watch.tick(5.02, 105.02 + step_s, lit=lit) is None
