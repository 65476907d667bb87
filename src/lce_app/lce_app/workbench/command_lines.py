# SPDX-License-Identifier: Apache-2.0
"""What the page does, as commands for a shell in its folder."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.workbench.state import WorkbenchState
from lce_data.files import printable

if TYPE_CHECKING:
    from lce_app.use_cases.fit import ModelChoice


def prepare(state: WorkbenchState) -> list[str]:
    """The runs in use that are prepared, each from its recording and its recipe."""
    entries = (state.entries[name] for name in state.used())
    return [
        _line(
            state, "prepare", entry.path, "--recipe", file.with_suffix(".recipe.yaml"), "--out", file.parent, "--force"
        )
        for entry in entries
        if (file := entry.prepared) is not None
    ]


def compare(state: WorkbenchState, model: Path) -> str:
    """The tab Compare, as a report."""
    runs = [*state.paths("train"), *state.paths("test")]
    return _line(state, "compare", runs, "--model", model, "--report", "compare.html")


def diagnose(state: WorkbenchState, model: Path) -> str:
    """The tab Diagnose, as a report."""
    return _line(state, "diagnose", *_runs(state), "--model", model, "--report", "diagnose.html")


def discover(state: WorkbenchState, model: Path) -> str:
    """What the tab Diagnose does where something is unexplained, as a report and an effect file."""
    outputs = "--report", "discover.html", "--out", "found.py"
    return _line(state, "discover", *_runs(state), "--model", model, *outputs)


def fit(state: WorkbenchState, choice: ModelChoice) -> str:
    """A model identified from scratch."""
    stages = "--thermal", str(choice.thermal), "--deformation", str(choice.deformation)
    effects = [word for effect in choice.effects for word in ("--effect", effect)]
    varies = [word for key in choice.varies for word in ("--varies", key)]
    return _line(state, "fit", state.paths("train"), *stages, *effects, *varies, "--out", "model.yaml")


def add(state: WorkbenchState, effect: str, model: Path) -> str:
    """One more effect."""
    return _line(state, "add", effect, *_runs(state), "--model", model, "--out", "model.yaml")


def design(state: WorkbenchState, model: Path, between: tuple[str, str], limits: tuple[float, float, float]) -> str:
    """A waveform that tells two effects apart, within limits of power [W], temperature [°C] and duration [s]."""
    power, temperature, duration = (f"{limit:g}" for limit in limits)
    within = "--max-power", power, "--max-temperature", temperature, "--duration", duration
    return _line(state, "design", "--model", model, "--between", ",".join(between), *within, "--out", "wave.csv")


def tell_apart(state: WorkbenchState, model: Path, first: Path, second: Path) -> str:
    """A waveform that tells two effect files apart."""
    between = ",".join(f"./{file.relative_to(state.folder).as_posix()}" for file in (first, second))
    return _line(state, "design", "--model", model, "--between", between, "--out", "wave.csv")


def _runs(state: WorkbenchState) -> tuple[str | Sequence[Path], ...]:
    held_out = state.paths("test")
    return (state.paths("train"), "--test", held_out) if held_out else (state.paths("train"),)


def _line(state: WorkbenchState, *words: str | Path | Sequence[Path]) -> str:
    """The words of a command, files named as from the folder of the page."""
    line = ["lce"]
    for word in words:
        if isinstance(word, str):
            line.append(word)
        else:
            files = [word] if isinstance(word, Path) else word
            line += [file.relative_to(state.folder).as_posix() for file in files]
    return printable(shlex.join(line))
