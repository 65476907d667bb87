# SPDX-License-Identifier: Apache-2.0
"""Child processes that end with us: on success, on an error, on Ctrl-C, and, if they are nodes, when we are killed."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from lce_data.errors import LceError
from lce_ros.parent import PARENT

_STOP_S = 8.0


class Processes:
    """Children by name; leaving the context ends them, the first started last.

    Each child prints into a file of its own in `logs`; if it dies, the error shows the last line of that file that is
    more than information.
    """

    def __init__(self, logs: Path) -> None:
        self._logs = logs
        self._running: dict[str, subprocess.Popen[bytes]] = {}

    def start(self, name: str, command: Sequence[str], pipe: bool = False) -> subprocess.Popen[bytes]:
        """Start a child, with a pipe for its stdout if asked.

        It gets a session of its own: Ctrl-C is for us alone, who then end the children in order. A node, and those that
        a launch starts, end by themselves when we are killed (lce_ros.parent).
        """
        with self._log(name).open("w") as log:
            self._running[name] = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE if pipe else log,
                stderr=log,
                start_new_session=True,
                env=os.environ | {PARENT: str(os.getpid())},
            )
        return self._running[name]

    def check(self, but: str = "") -> None:
        """Raise LceError if a child has ended, except the one that `but` names."""
        for name, process in self._running.items():
            status = process.poll()
            if status is not None and name != but:
                raise LceError(f"{name} ended early ({_how(status)}){self._last_words(name)}")

    def stop(self, name: str, after_s: float = 0.0) -> None:
        """End one child: wait `after_s` [s] for it to end by itself, then SIGINT, SIGTERM and SIGKILL in turn.

        Raises LceError if it ended with an error.
        """
        process = self._running.pop(name)
        waits = [
            (None, after_s),
            *((number, _STOP_S) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)),
        ]
        for number, wait_s in waits:
            if number is not None and process.poll() is None:
                process.send_signal(number)
            try:
                process.wait(wait_s)
                break
            except subprocess.TimeoutExpired:
                continue
        if process.stdout is not None:
            process.stdout.close()
        if process.returncode not in (0, -signal.SIGINT):
            raise LceError(f"{name} did not end well ({_how(process.returncode)}){self._last_words(name)}")

    def log(self, name: str) -> str:
        """What a child has printed."""
        return self._log(name).read_text(errors="replace")

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        problems = []
        names = list(self._running)
        for name in names[1:]:
            if self._running[name].poll() is None:
                self._running[name].send_signal(signal.SIGINT)
        for name in reversed(names):
            try:
                self.stop(name, after_s=0.0 if name == names[0] else _STOP_S)
            except LceError as problem:
                problems.append(str(problem))
        if problems and kind is None:
            raise LceError("; ".join(problems))

    def _log(self, name: str) -> Path:
        return self._logs / f"{name}.log"

    def _last_words(self, name: str) -> str:
        lines = [line for line in self.log(name).strip().splitlines() if not line.startswith("[INFO]")]
        return f": {lines[-1].strip()}" if lines else ""


def _how(status: int) -> str:
    return f"status {status}" if status >= 0 else f"killed by {signal.Signals(-status).name}"
