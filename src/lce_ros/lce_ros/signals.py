# SPDX-License-Identifier: Apache-2.0
"""Stop signals as a call, without an exception in the middle of something."""

import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

STOP_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class _Noted:
    """The handler of the stop signals within `stop_signals`.

    came : a signal has come.
    raises : the next one raises KeyboardInterrupt, see `interruptible`.
    """

    def __init__(self) -> None:
        self.came = self.raises = False

    def __call__(self, *_: object) -> None:
        self.came = True
        if self.raises:
            # The process ends, and what was half made at this moment would complain in its destructor.
            sys.unraisablehook = lambda _: None
            raise KeyboardInterrupt


@contextmanager
def stop_signals(stop: Callable[[], object]) -> Iterator[None]:
    """Call ``stop`` in a thread of its own when a stop signal comes; to be entered in the main thread.

    A Python signal handler runs only when the main thread is back from waiting in C, and an exception raised
    in it can come in the middle of a publish; the wake-up descriptor and a thread that reads it have neither
    flaw. A SIGHUP that the process was started to ignore (nohup) stays ignored. Signals that were blocked come now.
    """
    reader, writer = socket.socketpair()
    writer.setblocking(False)

    def watch() -> None:
        while number := reader.recv(1)[0]:
            if number in STOP_SIGNALS:
                stop()

    watcher = threading.Thread(target=watch, name="signals", daemon=True)
    noted = _Noted()
    before = {number: signal.signal(number, noted) for number in handled_signals()}
    wakeup = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    watcher.start()
    signal.pthread_sigmask(signal.SIG_UNBLOCK, before)
    try:
        yield
    finally:
        signal.set_wakeup_fd(wakeup)
        for number, handler in before.items():
            signal.signal(number, handler)
        writer.send(b"\0")
        watcher.join()
        reader.close()
        writer.close()


@contextmanager
def interruptible() -> Iterator[None]:
    """Let a stop signal raise KeyboardInterrupt at once, within `stop_signals`; elsewhere nothing changes.

    This is for long work that holds nothing open, such as the compilation of a kernel.
    """
    noted = signal.getsignal(signal.SIGINT)
    if not isinstance(noted, _Noted) or threading.current_thread() is not threading.main_thread():
        yield
        return
    noted.raises = True
    try:
        if noted.came:
            raise KeyboardInterrupt
        yield
    finally:
        noted.raises = False


def handled_signals() -> tuple[signal.Signals, ...]:
    """The stop signals, without a SIGHUP that the process was started to ignore."""
    ignored = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return tuple(number for number in STOP_SIGNALS if not (ignored and number is signal.SIGHUP))
