# SPDX-License-Identifier: Apache-2.0
"""Prepared runs as files: a recording and a recipe in, a run of its own out, as CSV with YAML beside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from lce_data.errors import LceError
from lce_data.preparing.recipe import Recipe, plain, prepared, write_recipe
from lce_data.preparing.steps import Merge
from lce_data.read_runs import read_recording, read_run, usable
from lce_data.run import Run
from lce_data.run_csv import write_run_csv


@dataclass(frozen=True)
class PreparedRun:
    """A recording, what its recipe makes of it, and what a user should know of the steps."""

    recording: Run
    run: Run
    warnings: tuple[str, ...] = ()


def prepare(recording: Run, recipe: Recipe, within: Path | None = None) -> PreparedRun:
    """Apply a recipe to a recording.

    Parameters
    ----------
    recording : as `read_recording` reads it.
    within : folder in which the files of merges have to be, links followed; anywhere if None.

    Raises
    ------
    LceError
        If a step makes no sense on the run, a file of a merge cannot be read, or the result is no run.
    """
    others = {path.name: read_recording(path.file) for path in merged_files(recording.path, recipe, within)}
    run, warnings = prepared(recording, recipe, others)
    return PreparedRun(recording, usable(run), warnings)


@dataclass(frozen=True)
class MergedFile:
    """A file of a merge: its name in the recipe, and where it is."""

    name: str
    file: Path


def merged_files(path: Path, recipe: Recipe, within: Path | None = None) -> tuple[MergedFile, ...]:
    """The files that a recipe adds to the run of a path. Raises LceError if one is not ``within`` a folder."""
    found = []
    for name in dict.fromkeys(step.file for step in recipe if isinstance(step, Merge)):
        file = path.parent / name
        if within is not None and not file.resolve().is_relative_to(within.resolve()):
            raise LceError(f"{name}: not in the folder {within}")
        found.append(MergedFile(name, file))
    return tuple(found)


def write_prepared(found: PreparedRun, recipe: Recipe, out: Path) -> Path:
    """Write a prepared run as ``out``, a CSV, with its conditions, its origin and its recipe beside it.

    The YAML of the same stem has ``prepared``: the recording, its SHA-256, and the steps. ``STEM.recipe.yaml`` is the
    recipe as `read_recipe` reads it. Raises LceError if a file cannot be written, or would replace the recording.
    """
    recording = found.recording
    if out.resolve() == recording.path.resolve():
        raise LceError(f"{out} is the recording; a prepared run goes elsewhere")
    about = recording.experiment
    origin = {"file": recording.path.name, "sha256": recording.sha256, "steps": plain(recipe)}
    # What was lost while recording has been seen to; counts of messages are no longer those of the samples.
    about = about.with_entries(lost=None, messages=None, other={**about.other, "prepared": origin})
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LceError(f"{out.parent}: cannot be made ({error.strerror})") from None
    write_run_csv(out, *found.run.aligned(), about)
    write_recipe(out.with_suffix(".recipe.yaml"), recipe)
    return out


def read_back(found: PreparedRun, file: Path) -> Run:
    """The run as everybody reads it from the file that `write_prepared` wrote, with the markers of the recording."""
    return replace(read_run(file), markers=found.run.markers)
