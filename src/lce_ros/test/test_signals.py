# SPDX-License-Identifier: Apache-2.0
import os
import signal
import sys
import threading

import pytest

from lce_ros.signals import STOP_SIGNALS, interruptible, stop_signals


@pytest.mark.parametrize("number", STOP_SIGNALS)
def test_a_stop_signal_becomes_a_call_and_nothing_is_interrupted(number: signal.Signals) -> None:
    called = threading.Event()
    with stop_signals(called.set):
        os.kill(os.getpid(), number)
        assert called.wait(2.0)


def test_the_handlers_before_come_back() -> None:
    before = [signal.getsignal(s) for s in STOP_SIGNALS]
    with stop_signals(lambda: None):
        assert [signal.getsignal(s) for s in STOP_SIGNALS] != before
    assert [signal.getsignal(s) for s in STOP_SIGNALS] == before
    assert signal.set_wakeup_fd(-1) == -1


def test_an_ignored_hang_up_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stop_signals(lambda: None):
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.fixture
def unraisable(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt silences destructors for the rest of its process, here for the rest of the test."""
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)


@pytest.mark.usefixtures("unraisable")
def test_a_stop_signal_ends_what_is_interruptible_at_once() -> None:
    called = threading.Event()
    with stop_signals(called.set):
        with pytest.raises(KeyboardInterrupt), interruptible():
            signal.raise_signal(signal.SIGTERM)
        assert called.wait(2.0)


def test_a_stop_signal_that_came_before_counts() -> None:
    called = threading.Event()
    with stop_signals(called.set):
        os.kill(os.getpid(), signal.SIGINT)
        assert called.wait(2.0)
        with pytest.raises(KeyboardInterrupt), interruptible():
            pytest.fail("began")


def test_nothing_is_interruptible_where_nobody_handles_the_signals() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruptible():
        assert signal.getsignal(signal.SIGINT) is before
