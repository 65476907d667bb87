# SPDX-License-Identifier: Apache-2.0
from itertools import product

import numpy as np

from lce_drivers.laser.arming import Arming
from lce_drivers.laser.sole_source import HOLD_S, SoleSource


def test_light_needs_arming_and_arming_needs_a_command_of_zero() -> None:
    arming = Arming()
    assert not arming.armed
    assert arming.arm(0.5, 1.0) == "0.5 W are commanded; command zero first" and not arming.armed
    assert arming.arm(float("nan"), 1.0) is not None and not arming.armed
    assert "call again" in str(arming.arm(0.0, 0.09)) and not arming.armed, "not everybody knows yet"
    assert arming.arm(0.0, 1.0) is None and arming.armed
    arming.disarm()
    assert not arming.armed and arming.fault is None


def test_a_fault_stays_until_the_reset_and_a_reset_does_not_arm() -> None:
    arming = Arming(armed=True)
    arming.latch(None)
    assert arming.armed
    arming.latch("too hot")
    arming.latch("no temperature")
    assert not arming.armed and arming.fault == "too hot", "the first one is told"
    assert "too hot" in str(arming.arm(0.0, 1.0)) and not arming.armed
    assert arming.reset("it is still hot") == "not cleared, it is still hot: too hot" and arming.fault is not None
    assert arming.reset(None) == "cleared: too hot; disarmed" and arming.fault is None
    assert not arming.armed and arming.reset(None) == "there was no fault"


def test_in_no_order_of_events_is_it_armed_without_an_arm_after_the_last_fault() -> None:
    events = ("latch", "reset", "blocked", "arm", "lit", "disarm")
    for order in product(events, repeat=5):
        arming, armed, fault = Arming(), False, False
        for event in order:
            if event == "latch":
                arming.latch("x")
                armed, fault = False, True
            elif event in ("reset", "blocked"):
                arming.reset(None if event == "reset" else "still")
                fault = fault and event == "blocked"
            elif event in ("arm", "lit"):
                arming.arm(0.0 if event == "arm" else 0.5, 1.0)
                armed = armed or (event == "arm" and not fault)
                assert arming.arm(0.5, 1.0) is None or not armed, "armed already, it stays so"
            else:
                arming.disarm()
                armed = False
            assert (arming.armed, arming.fault is not None) == (armed, fault), order


def test_one_publisher_is_none_too_many_however_much_of_it_is_lost() -> None:
    source, random, number = SoleSource("x"), np.random.default_rng(1), 0
    for k in range(1000):
        number += int(random.integers(1, 20))
        assert source.heard(number, 0.01 * k) is None
    assert source.obstacle(10.0) is None


def test_a_second_publisher_is_noticed_by_its_first_message_or_by_the_next_of_the_other() -> None:
    for first, second in ((500, 1), (1, 500), (500, 500)):
        source, found = SoleSource("laser/power_command"), []
        for k in range(4):
            found += [source.heard(first + k, 0.01 * k), source.heard(second + k, 0.01 * k + 0.005)]
        assert found[0] is None and "a second node publishes laser/power_command" in found[1:3]
        assert source.obstacle(0.1) == "two nodes still publish laser/power_command"


def test_a_publisher_may_follow_another_that_has_let_go() -> None:
    source = SoleSource("x")
    assert source.heard(500, 1.0) is None
    assert source.heard(1, 1.0 + HOLD_S) is None
    assert source.heard(2, 1.01 + HOLD_S) is None
    assert source.heard(1, 1.02 + HOLD_S) is not None
    assert source.obstacle(1.5 + HOLD_S) is not None and source.obstacle(1.03 + 2 * HOLD_S) is None


def test_a_middleware_that_does_not_number_messages_gives_no_light() -> None:
    assert "use rmw_fastrtps_cpp" in str(SoleSource("x").heard(None, 1.0))
