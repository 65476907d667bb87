# SPDX-License-Identifier: Apache-2.0
from lce_ros.repeats import LATE_NS, Repeats


def test_the_second_copy_of_a_message_is_a_repeat() -> None:
    repeats = Repeats()
    assert [repeats.has(sent_ns) for sent_ns in (5, 5, 7, 7)] == [False, True, False, True]


def test_a_copy_that_comes_after_a_newer_message_is_a_repeat() -> None:
    repeats = Repeats()
    assert [repeats.has(sent_ns) for sent_ns in (5, 7, 5)] == [False, False, True]


def test_a_publisher_whose_clock_is_far_behind_is_heard() -> None:
    repeats = Repeats()
    assert [repeats.has(sent_ns) for sent_ns in (2 * LATE_NS, LATE_NS, LATE_NS, 2 * LATE_NS)] == [
        False, False, True, False,
    ]  # fmt: skip
