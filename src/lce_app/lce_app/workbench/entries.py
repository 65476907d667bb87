# SPDX-License-Identifier: Apache-2.0
"""A file that may be a run, as the page uses it: as it was recorded, or prepared by its recipe."""

from __future__ import annotations

import re
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lce_app.workbench.session import Session
from lce_data.errors import LceError
from lce_data.files import printable

if TYPE_CHECKING:
    from lce_data.preparing.recipe import Recipe
    from lce_data.run import Run

NAMED: Final = re.compile("[0-9a-f]{8}")
"""Folders of prepared runs."""


@dataclass(frozen=True)
class RunEntry:
    """A file that may be a run: the run once it is read and what looks wrong about it, or why it cannot be used.

    path : the recording.
    file : what jobs read: the recording, or the prepared run.
    recording : what is in ``path``, perhaps no run by itself; None if it cannot be read, or was not yet.
    run : what everything on the page uses.
    recipe : by which ``run`` was made of ``recording``.
    """

    path: Path
    run: Run | None = None
    error: str = ""
    warnings: tuple[str, ...] = ()
    recording: Run | None = None
    recipe: Recipe = ()
    prepared: Path | None = None

    @property
    def file(self) -> Path:
        """What jobs read."""
        return self.prepared or self.path


def read_entry(path: Path, name: str, session: Session) -> RunEntry:
    """The run of a file, named after its place in the folder: two runs may have one name, in two folders."""
    from lce_data.read_runs import read_recording

    try:
        recording = replace(read_recording(path), name=name.removesuffix(".csv").removesuffix(".mcap"))
    except LceError as error:
        return RunEntry(path, error=_told(error, session), recipe=session.recipe(name))
    return with_recipe(RunEntry(path, recording=recording), name, session.recipe(name), session)


def with_recipe(entry: RunEntry, name: str, recipe: Recipe, session: Session) -> RunEntry:
    """The same entry, prepared by a recipe; if that fails it says why."""
    try:
        return prepare_entry(entry, name, recipe, session)
    except LceError as error:
        return RunEntry(entry.path, error=_told(error, session), recording=entry.recording, recipe=recipe)


def prepare_entry(entry: RunEntry, name: str, recipe: Recipe, session: Session) -> RunEntry:
    """The same entry, prepared by a recipe; its file is written. Raises LceError if a step makes no sense on it."""
    from lce_data.losses import lost_samples
    from lce_data.preparing.prepared_run import prepare, read_back, write_prepared
    from lce_data.read_runs import usable
    from lce_data.suspicions import suspicions

    recording = entry.recording
    if recording is None:
        raise LceError(f"{name}: {entry.error or 'not read'}")
    if not recipe:
        return RunEntry(entry.path, usable(recording), warnings=suspicions(recording), recording=recording)
    found = prepare(recording, recipe, within=session.folder)
    file = session.prepared_file(name, entry.path, recipe)
    if session.prepared.exists() and not session.prepared.resolve().is_relative_to(session.folder):
        raise LceError(f"{session.prepared}: a link that leads out of the folder")
    write_prepared(found, recipe, file)
    run = replace(read_back(found, file), name=recording.name)
    lost = lost_samples(recording)
    said = (*(f"{run.name}: {text}" for text in (*found.warnings, lost) if text), *suspicions(run))
    return RunEntry(entry.path, run, "", said, recording, recipe, file)


def _told(error: LceError, session: Session) -> str:
    """An error as the page shows it, files named from its folder."""
    return printable(str(error).replace(f"{session.folder}/", ""))


def forget_unused(session: Session, entries: dict[str, RunEntry]) -> None:
    """Remove the prepared runs that no run in use and no command of a model names."""
    if not session.prepared.is_dir() or session.prepared.is_symlink():
        return
    used = {entry.prepared.parent.name for entry in entries.values() if entry.prepared is not None}
    commands = " ".join(kept.command for kept in session.models)
    for folder in session.prepared.iterdir():
        ours = NAMED.fullmatch(folder.name) and not folder.is_symlink()
        if ours and folder.name not in used and f"/{folder.name}/" not in commands:
            shutil.rmtree(folder, ignore_errors=True)
