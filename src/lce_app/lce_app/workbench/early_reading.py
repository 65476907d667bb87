# SPDX-License-Identifier: Apache-2.0
"""Runs are read by another process while this one imports the server: they are there when the page is."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lce_app.workbench.entries import RunEntry, read_entry

if TYPE_CHECKING:
    from lce_app.workbench.session import Session

READERS: Final = ("lce_data.read_runs", "polars")
"""What reads runs, and takes a while to import."""
NICENESS: Final = 10
"""The page is needed before the runs."""


class EarlyReading:
    """A copy of this process that reads runs one after another. It ends when this one does, or after the last.

    It is to be made before this process has threads, and before Polars is imported, which does not survive a fork.

    Parameters
    ----------
    paths : of the runs to read, by their names.
    session : of the folder that they are in.
    """

    def __init__(self, paths: Mapping[str, Path], session: Session) -> None:
        context = multiprocessing.get_context("fork")
        self._paths = paths
        self._receive, send = context.Pipe(duplex=False)
        arguments = (self._receive, send, paths, session)
        self._process = context.Process(target=_read_all, args=arguments, daemon=True)
        self._process.start()
        send.close()
        self._one = threading.Lock()

    def __iter__(self) -> Iterator[tuple[str, RunEntry]]:
        """Name and run, as each is read, until all are or the process was killed; whoever asks later gets none."""
        with self._one, suppress(EOFError):
            for name in self._paths:
                yield name, self._receive.recv()
        self._process.join()

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()


def _read_all(receive: Connection, send: Connection, paths: Mapping[str, Path], session: Session) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the server, and that this process
    os.nice(NICENESS)
    receive.close()  # or nobody would tell that the server has ended
    with suppress(BrokenPipeError, KeyboardInterrupt):  # Polars hears Ctrl-C all the same
        for module in READERS:
            importlib.import_module(module)
        for name, path in paths.items():
            send.send(read_entry(path, name, session))
