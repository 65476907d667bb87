# SPDX-License-Identifier: Apache-2.0
"""The process in which `make fuzz` gives its commands, one after the other, to one `lce` that stays loaded."""

import asyncio
import io
import sys
import time
import traceback
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

LIMIT_S: Final = 10.0
"""Longest computation [s] for one command; a fit shows how far it is, and may take six times that."""
PAGE: Final = "page @."
"""Not a command: everything that the page reads of a folder, and shows of its runs."""


@dataclass(frozen=True)
class Answer:
    """What came of a case: the exit status of its last command, None if it hung or died; stderr; the traceback.

    seconds : of computation, by all threads of the process; of a fit a sixth of it.
    """

    status: int | None
    said: str
    traceback: str = ""
    seconds: float = 0.0

    @property
    def fault(self) -> str:
        """What is wrong with it, "" if nothing is."""
        if self.status is None:
            return self.said
        if self.traceback:
            return self.traceback.strip().splitlines()[-1]
        if self.seconds > LIMIT_S:
            return f"{self.seconds:.0f} s of computation"
        lines = [line for line in self.said.splitlines() if not line.startswith("lce: warning: ")]
        if self.status == 1 and not (len(lines) == 1 and lines[0].startswith("lce: ")):
            return f"status 1 with {len(lines)} lines: {self.said!r}"
        return "" if self.status in (0, 1) else f"status {self.status}: {self.said!r}"


def answer_for_ever(connection: Connection, good: Path) -> None:
    """Run what comes through the connection, a list of commands at a time, until the process is killed."""
    for words in (
        ["compare", str(good / "run.csv"), "--model", str(good / "m.yaml")],
        ["effects", str(good / "late.py")],
    ):
        warm = answer(words)
        assert warm.status == 0, warm
    connection.send("ready")
    while True:
        said = Answer(0, "")
        for words in connection.recv():
            said = answer(words)
            if said.fault:
                break
        connection.send(said)


def answer(words: list[str]) -> Answer:
    """Run one command; stdout and stderr take what those of a terminal take."""
    from lce_app.cli.main import main

    said = io.BytesIO()
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8")
    err = io.TextIOWrapper(said, encoding="utf-8", errors="backslashreplace")
    status: int | None = 1
    trace, began = "", time.process_time()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            status = _page(Path(words[1])) if words[0] == PAGE.split()[0] else main(words)
            out.flush()
        except SystemExit as end:  # argparse
            status = end.code if isinstance(end.code, int) else 1
        except BaseException:  # noqa: BLE001  whatever it is, it is a fault that is told
            trace = traceback.format_exc()
    err.flush()
    seconds = (time.process_time() - began) / (6.0 if words[0] == "fit" else 1.0)
    return Answer(status, said.getvalue().decode(), trace, seconds)


def _page(folder: Path) -> int:
    """Read a folder as the page does: session, runs, models, records. Each may say that it cannot be used."""
    from lce_app.workbench.state import WorkbenchState
    from lce_app.workbench.tabs import runs
    from lce_data.errors import LceError

    try:
        state = WorkbenchState(folder)
        asyncio.run(state.open())
        for entry in state.entries.values():
            if entry.run is not None:
                runs.conditions(entry.run)
                runs.measured(entry.run)
        state.model()
        state.designs()
    except LceError as error:
        print(f"lce: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    return 0
