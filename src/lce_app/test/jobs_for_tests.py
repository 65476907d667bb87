# SPDX-License-Identifier: Apache-2.0
"""Jobs of every outcome; a module of their own, as the process of a job imports it."""

import os
import signal
from pathlib import Path

from lce_data.errors import LceError
from lce_data.progress import Progress


def counting(out: Path, *, progress: Progress) -> None:
    """A job that does as it should."""
    for done in range(3):
        progress("counting", done, 3, 3.0 - done)
    out.write_text("done")


def warning(*, progress: Progress) -> list[str]:
    """A job whose result comes with a warning."""
    return ["stranger: is it of another strip?"]


def refusing(*, progress: Progress) -> None:
    """A job that finds its data wanting."""
    raise LceError("no\nrun")


def crashing(out: Path, *, progress: Progress) -> None:
    """A job that takes its process with it."""
    os.kill(os.getpid(), signal.SIGSEGV)


def endless(out: Path, *, progress: Progress) -> None:
    """A job that has to be stopped."""
    progress("waiting", 0, 1, 1.0)
    while True:
        signal.pause()
