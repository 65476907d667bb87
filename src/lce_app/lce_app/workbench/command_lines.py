# SPDX-License-Identifier: Apache-2.0
"""What the page does, as commands for a shell in its folder."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from lce_app.workbench.bench import Workbench


def compare(bench: Workbench, model: Path) -> str:
    """The tab Look, as a report."""
    runs = [*bench.paths("train"), *bench.paths("test")]
    return _line(bench, "compare", runs, "--model", model, "--report", "compare.html")


def diagnose(bench: Workbench, model: Path) -> str:
    """The tab Learn, as a report."""
    return _line(bench, "diagnose", *_runs(bench), "--model", model, "--report", "diagnose.html")


def fit(bench: Workbench, thermal: str, deformation: str) -> str:
    """A model without effects."""
    stages = "--thermal", thermal, "--deformation", deformation
    return _line(bench, "fit", bench.paths("train"), *stages, "--out", "model.yaml")


def add(bench: Workbench, effect: str, model: Path) -> str:
    """An effect more."""
    return _line(bench, "add", effect, *_runs(bench), "--model", model, "--out", "model.yaml")


def design(bench: Workbench, model: Path, between: tuple[str, str], limits: tuple[float, float, float]) -> str:
    """A waveform that tells two effects apart, within limits of power [W], temperature [°C] and duration [s]."""
    power, temperature, duration = (f"{limit:g}" for limit in limits)
    within = "--max-power", power, "--max-temperature", temperature, "--duration", duration
    return _line(bench, "design", "--model", model, "--between", ",".join(between), *within, "--out", "wave.csv")


def _runs(bench: Workbench) -> tuple[str | Sequence[Path], ...]:
    held_out = bench.paths("test")
    return (bench.paths("train"), "--test", held_out) if held_out else (bench.paths("train"),)


def _line(bench: Workbench, *words: str | Path | Sequence[Path]) -> str:
    """The words of a command, files named as from the folder of the page."""
    line = ["lce"]
    for word in words:
        if isinstance(word, str):
            line.append(word)
        else:
            files = [word] if isinstance(word, Path) else word
            line += [file.relative_to(bench.folder).as_posix() for file in files]
    return shlex.join(line)
