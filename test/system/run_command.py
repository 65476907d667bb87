# SPDX-License-Identifier: Apache-2.0
"""The `lce` command as a process, and what it leaves: for the tests of runs and recordings."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

LCE = [sys.executable, "-m", "lce_app.cli.main"]
MARK = "LCE_TEST_RUN"
"""Environment variable by which the processes of a run are known, even orphans."""

Floats = NDArray[np.float64]


def lce(*words: str, cwd: Path | None = None, timeout_s: float = 60.0) -> subprocess.CompletedProcess[str]:
    """Run a command to its end."""
    return subprocess.run([*LCE, *words], capture_output=True, text=True, timeout=timeout_s, cwd=cwd, check=False)


@contextmanager
def started(*words: str, command: Sequence[str] = LCE) -> Iterator["Running"]:
    """A command under way; whatever is left of it in the end is killed."""
    mark = f"{os.getpid()}-{time.monotonic_ns()}"
    process = subprocess.Popen(
        [*command, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {MARK: mark, "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"},  # killed, it leaves no shared memory
    )
    running = Running(process, mark)
    try:
        yield running
    finally:
        for pid in running.processes():
            os.kill(pid, signal.SIGKILL)
        print(*process.communicate(), sep="\n")  # pytest shows it where a test fails


class Running:
    """A started command and the node processes that belong to it."""

    def __init__(self, process: "subprocess.Popen[str]", mark: str) -> None:
        self.process = process
        self._mark = f"{MARK}={mark}".encode()

    def processes(self, module: str = "") -> list[int]:
        """Process ids, of those only that run a module if one is named."""
        found = []
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                ours = self._mark in (folder / "environ").read_bytes().split(b"\0")
                command = (folder / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if ours and command != [b""] and (not module or module.encode() in command):
                found.append(int(folder.name))
        return found


def until(condition: Callable[[], Any], what: str, timeout_s: float = 30.0) -> Any:
    """Wait for a condition in another process; AssertionError after the time-out."""
    end = time.monotonic() + timeout_s
    while not (result := condition()):
        assert time.monotonic() < end, f"{what} did not come true within {timeout_s:g} s"
        threading.Event().wait(0.05)
    return result


def read(bag: Path) -> dict[str, tuple[Floats, list[Any]]]:
    """Log times [s] and messages of a bag by topic."""
    found: dict[str, tuple[list[int], list[Any]]] = {}
    with AnyReader([bag]) as reader:
        for connection, time_ns, data in reader.messages():
            times, messages = found.setdefault(connection.topic, ([], []))
            times.append(time_ns)
            messages.append(reader.deserialize(data, connection.msgtype))
    return {topic: (np.array(times) / 1e9, messages) for topic, (times, messages) in found.items()}


def values(bag: Path, topic: str) -> tuple[Floats, Floats]:
    """Log times [s] and numbers of a Float64 or Temperature topic."""
    times, messages = read(bag)[topic]
    field = "temperature" if topic.endswith("temperature") else "data"
    return times, np.array([getattr(message, field) for message in messages])


def experiment(bag: Path) -> dict[str, Any]:
    """The experiment.yaml beside a bag."""
    content: dict[str, Any] = yaml.safe_load((bag / "experiment.yaml").read_text())
    return content
