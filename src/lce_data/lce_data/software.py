# SPDX-License-Identifier: Apache-2.0
"""Which software is running: its version, Python's, and the commit if it runs from its own git repository."""

from __future__ import annotations

import os
import platform
import subprocess
from functools import cache
from pathlib import Path
from typing import Final

from lce_data import __version__

PATIENCE_S: Final = 2.0
"""Longest wait for git [s]."""
_SOURCE: Final = Path(__file__).resolve()
_IN_REPOSITORY: Final = Path("src/lce_data/lce_data") / _SOURCE.name


def software() -> dict[str, str]:
    """Versions by name: ``lce``, ``python``, and ``git`` where `git describe` answers for this source."""
    versions = {"lce": __version__, "python": platform.python_version()}
    return versions | ({"git": commit} if (commit := _commit()) else {})


@cache
def _commit() -> str:
    """What ``git describe`` says of the repository of this file, with -dirty if it has changes; "" without one.

    An installed copy may lie in somebody else's repository, whose commit would say nothing about it.
    """
    root = _SOURCE.parents[len(_IN_REPOSITORY.parts) - 1]
    if root / _IN_REPOSITORY != _SOURCE or not (root / ".git").exists():
        return ""
    try:
        done = subprocess.run(
            ["git", "-C", str(root), "describe", "--always", "--tags", "--dirty"],
            env=os.environ | {"GIT_OPTIONAL_LOCKS": "0"},
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
