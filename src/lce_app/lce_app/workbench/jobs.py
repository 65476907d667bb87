# SPDX-License-Identifier: Apache-2.0
"""Long work in a process of its own: the page stays live, the work can be stopped, and its crash harms nobody."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from typing import Any, Final, Literal, NoReturn

from lce_data.errors import LceError
from lce_ros.parent import when_parent_ends

State = Literal["running", "done", "failed", "cancelled"]
PERIOD_S: Final = 0.1
"""Time between two reports of a job [s], at least."""
_FORK: Final = multiprocessing.get_context("forkserver")

Task = Callable[..., Sequence[str] | None]
"""What a job calls, with keyword arguments and ``progress`` (lce_data.progress.Progress).

Its results are files; it returns the warnings that the command of `lce` would print, if any.
"""


def warm_up() -> None:
    """Start the process from which jobs are forked, with the libraries that they need."""
    _FORK.set_forkserver_preload(["lce_app.workbench.tasks"])
    from multiprocessing.forkserver import ensure_running

    ensure_running()


@dataclass(frozen=True)
class JobStep:
    """Where a job is: seconds since its start, what it does, steps done and at most, RMS error in units of noise."""

    seconds: float
    label: str
    done: int
    total: int
    rms: float


@dataclass(frozen=True)
class JobEnd:
    """How a job ended, the line that says what went wrong, and its warnings."""

    state: State
    error: str = ""
    warnings: tuple[str, ...] = ()


@dataclass
class Job:
    """Work under way. ``poll`` often; ``steps`` are those it reported, ``error`` is the line that says what went wrong.

    ``warnings`` are those of its result.

    measure : what the number of its steps is.
    gentle : a cancelled job is interrupted instead of killed, because it controls or records something.
    only_listens : it commands nothing, so to stop the bench does not end it.
    """

    name: str
    task: Task
    arguments: dict[str, Any]
    measure: str = "RMS error"
    gentle: bool = False
    only_listens: bool = False
    state: State = "running"
    error: str = ""
    warnings: tuple[str, ...] = ()
    steps: list[JobStep] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._receive, send = _FORK.Pipe(duplex=False)
        self._began, self._stop_wanted = time.monotonic(), False
        self._process = _FORK.Process(target=_run, args=(send, os.getpid(), self.task, self.arguments), daemon=True)
        self._process.start()
        send.close()

    def poll(self) -> bool:
        """Take in what the job reported; True if something is new."""
        new = False
        while self.state == "running" and self._receive.poll():
            try:
                message = self._receive.recv()
            except EOFError:
                self._process.join()
                answer = f"{self.name}: its process ended without an answer ({self._process.exitcode})"
                self._end(JobEnd("failed", answer))
                return True
            new = True
            match message:
                case (label, done, total, rms):
                    self.steps.append(JobStep(self.seconds, label, done, total, rms))
                    if self._stop_wanted:
                        self.cancel()
                case JobEnd():
                    self._end(message)
        return new

    @property
    def seconds(self) -> float:
        """Time since its start [s]."""
        return time.monotonic() - self._began

    def cancel(self) -> None:
        """End the job: a gentle one by Ctrl-C, any other at once; no file is left half-written."""
        if self.state != "running":
            return
        if self.gentle and self._process.pid is not None:
            # Before its first report the process does not yet end in order.
            self._stop_wanted = not self.steps
            if self.steps:
                with suppress(ProcessLookupError):  # it has ended; poll takes in how
                    os.kill(self._process.pid, signal.SIGINT)
            return
        self._process.kill()
        self._process.join()
        self._end(JobEnd("cancelled"))

    def wait(self, timeout_s: float | None = None) -> None:
        """Wait until its process has ended."""
        self._process.join(timeout_s)

    def stop(self) -> None:
        """Cancel it, and wait until it has ended in order."""
        self.cancel()
        while self.state == "running":  # the wish to stop a job that still starts is passed on by poll
            self.poll()
            self.wait(PERIOD_S)
        self.wait()

    def _end(self, end: JobEnd) -> None:
        self.state, self.error, self.warnings = end.state, end.error, end.warnings
        self._receive.close()


def _run(send: Connection, server: int, task: Task, arguments: dict[str, Any]) -> None:
    """In the process of the job. It ends in order when it is interrupted, or when the server is gone."""
    signal.signal(signal.SIGINT, _interrupted_once)
    signal.signal(signal.SIGHUP, _interrupted_once)
    reported, main = -math.inf, threading.get_ident()

    def progress(label: str, done: int, total: int, rms: float) -> None:
        nonlocal reported
        now = time.monotonic()
        if now - reported < PERIOD_S:
            return
        reported = now
        try:
            send.send((label, done, total, rms))
        except BrokenPipeError:
            _interrupted_once()

    try:
        # To the main thread: a system call in which it waits ends only there.
        with when_parent_ends(lambda: signal.pthread_kill(main, signal.SIGINT), server):
            progress("starting", 0, 1, math.nan)
            end = JobEnd("done", warnings=tuple(task(progress=progress, **arguments) or ()))
    except LceError as error:
        end = JobEnd("failed", " ".join(str(error).split()))
    except KeyboardInterrupt:
        end = JobEnd("cancelled")
    with suppress(BrokenPipeError):
        send.send(end)


def _interrupted_once(*_: object) -> NoReturn:
    """Ctrl-C in a terminal comes here and to the server, which passes it on: the second one must not disturb what the
    first one ends in order.
    """
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt
