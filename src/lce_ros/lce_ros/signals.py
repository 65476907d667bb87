# SPDX-License-Identifier: Apache-2.0
"""Stop signals as a call, without an exception in the middle of something."""

import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

STOP_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def stop_signals(stop: Callable[[], object]) -> Iterator[None]:
    """Call ``stop`` in a thread of its own when a stop signal comes; to be entered in the main thread.

    A Python signal handler runs only when the main thread is back from waiting in C, and an exception raised
    in it can come in the middle of a publish; the wake-up descriptor and a thread that reads it have neither
    flaw. A SIGHUP that the process was started to ignore (nohup) stays ignored.
    """
    reader, writer = socket.socketpair()
    writer.setblocking(False)

    def watch() -> None:
        while number := reader.recv(1)[0]:
            if number in STOP_SIGNALS:
                stop()

    watcher = threading.Thread(target=watch, name="signals", daemon=True)
    handled = [s for s in STOP_SIGNALS if s is not signal.SIGHUP or signal.getsignal(s) is not signal.SIG_IGN]
    before = {s: signal.signal(s, lambda *_: None) for s in handled}
    wakeup = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    watcher.start()
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
