# SPDX-License-Identifier: Apache-2.0
"""Walk the shell commands of a page on data that lie on this machine, in place of the download."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

import heater

CLONE = "pyomo-doe"
PREFIX = "validation_experiment_env_2_"
"""In front of the names of the heater runs where they are published."""


def blocks(page: str, kind: str) -> list[str]:
    """The code blocks of one kind of a page, in their order."""
    found = re.findall(r"^```(.*?)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == kind]


def as_downloaded(source: Path, place: Path) -> None:
    """Put the heater runs where `git clone` would put them."""
    data = place / CLONE / "data"
    data.mkdir(parents=True)
    for name in heater.RUNS:
        shutil.copy(source / f"{name}.csv", data / f"{PREFIX}{name}.csv")


def run(scripts: Iterable[str], place: Path) -> list[str]:
    """What each script prints in a folder, but for the download. Raises CalledProcessError if a command fails."""
    said = []
    for script in scripts:
        kept = "\n".join(line for line in script.splitlines() if not line.startswith("git clone"))
        done = subprocess.run(["bash", "-euc", kept], cwd=place, capture_output=True, text=True, check=True)
        said.append(done.stdout)
    return said
