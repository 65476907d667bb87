# SPDX-License-Identifier: Apache-2.0
"""A slow device read in a thread of its own, so that no executor ever waits for it."""

import threading
from collections.abc import Callable
from typing import Final, Protocol

from lce_drivers.sensor import Reading

NOT_YET: Final = "not connected yet"
START_S: Final = 5.0
"""Longest time [s] from the start of the thread to a first reading: a camera takes two."""


class NoReading(Exception):
    """The device is there but has no value: over range, in its settings, a frame lost."""


class Link(Protocol):
    """An open connection to a device."""

    def read(self) -> Reading | None:
        """Wait a short time (at most about 0.2 s) for a reading; None if it does not come.

        Raises NoReading if the device says that it has no value, OSError if the connection is broken.
        """

    def close(self) -> None:
        """Let go of the connection."""


class Background:
    """A SensorDevice that keeps the newest reading of a link, and connects again when the link breaks.

    ``poll`` returns each reading at most once and never waits.
    """

    def __init__(self, connect: Callable[[], Link], name: str, retry_s: float = 1.0) -> None:
        """``connect`` opens the link or raises OSError; only the thread uses it and the link."""
        self._connect = connect
        self._retry_s = retry_s
        self._newest: Reading | None = None
        self._fault: str | None = NOT_YET
        self._first = threading.Event()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def poll(self) -> Reading | None:
        """The newest reading, if an earlier call has not returned it; else None."""
        reading, self._newest = self._newest, None
        return reading

    def check(self) -> None:
        """Wait for the first reading. Raises OSError if none comes within START_S."""
        if not self._first.wait(START_S):
            raise OSError(self.fault() or NOT_YET)

    def fault(self) -> str | None:
        """What is wrong with the device at present, or None."""
        if not self._thread.is_alive():
            return "the thread that reads the device has ended"
        return self._fault

    def close(self) -> None:
        """End the thread and with it the link."""
        self._stop.set()
        self._thread.join(timeout=5.0)

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                link = self._connect()
                try:
                    self._read(link)
                finally:
                    link.close()
            except OSError as error:
                self._fault = str(error)
                self._stop.wait(self._retry_s)

    def _read(self, link: Link) -> None:
        while not self._stop.is_set():
            try:
                reading = link.read()
            except NoReading as why:
                self._fault = str(why)
                continue
            if reading is not None:
                self._newest, self._fault = reading, None
                self._first.set()
