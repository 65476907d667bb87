# SPDX-License-Identifier: Apache-2.0
"""The user's decisions in the workbench, in ``FOLDER/workbench/``: roles of runs, models, and the current model.

A model is a numbered file that is never changed; undo goes back to its parent.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

from msgspec import Struct, to_builtins

from lce_data.errors import LceError
from lce_data.files import printable, write_atomically
from lce_data.schema import checked, read_yaml
from lce_data.yaml_text import dump

Role = Literal["train", "test", "off"]
NAME: Final = "workbench"
FILE_NAME: Final = "session.yaml"


class Kept(Struct, frozen=True, forbid_unknown_fields=True):
    """A model of the history: its number, how it came about, its parent's number, and the command that makes it."""

    number: int
    how: str
    parent: int | None = None
    command: str = ""


class SessionFile(Struct, frozen=True):
    """The content of ``session.yaml``: the role of each run by its path, the models, the current one's number."""

    format: Literal["lce-workbench-1"]
    roles: dict[str, Role]
    models: list[Kept]
    current: int | None


@dataclass(frozen=True)
class Session:
    """An immutable state of the page. Runs are named by their paths in ``folder``."""

    folder: Path
    roles: Mapping[str, Role]
    models: tuple[Kept, ...] = ()
    current: int | None = None

    @property
    def place(self) -> Path:
        """Where its files are."""
        return self.folder / NAME

    def model_file(self, number: int) -> Path:
        """File of a model of the history."""
        return self.place / f"model-{number}.yaml"

    def diagnosis_file(self, number: int) -> Path:
        """What `diagnose` said of a model."""
        return self.place / f"diagnosis-{number}.json"

    def discovery_file(self, number: int) -> Path:
        """What `discover` said of a model."""
        return self.place / f"discovery-{number}.json"

    def next_found_file(self, number: int) -> Path:
        """An effect file for what is discovered of a model. None is written twice: models may name an earlier one."""
        found = self.place / f"found-{number}.py"
        count = 1
        while found.exists():
            count += 1
            found = self.place / f"found-{number}-{count}.py"
        return found

    def addition_file(self, number: int) -> Path:
        """What `add` said of the effect by which a model was made."""
        return self.model_file(number).with_suffix(".json")

    def kept(self, number: int) -> Kept:
        """A model of the history. Raises LceError if no model has that number."""
        for entry in self.models:
            if entry.number == number:
                return entry
        raise LceError(f"{self.place}: there is no model {number}")

    def names(self, role: Role) -> tuple[str, ...]:
        """Runs of one role."""
        return tuple(name for name, r in self.roles.items() if r == role)

    def with_role(self, name: str, role: Role) -> Session:
        """The same session, with another role of a run."""
        return replace(self, roles={**self.roles, name: role})

    def next_number(self) -> int:
        """Number of the next model."""
        return 1 + max((entry.number for entry in self.models), default=0)

    def with_model(self, how: str, parent: int | None, command: str = "") -> Session:
        """The same session, with the model of the next number in its history and current."""
        entry = Kept(self.next_number(), how, parent, command)
        return replace(self, models=(*self.models, entry), current=entry.number)

    def with_current(self, number: int) -> Session:
        """The same session, with another model of the history current."""
        return replace(self, current=self.kept(number).number)

    def undone(self) -> Session:
        """The parent of the current model is current again. Raises LceError if there is no such parent."""
        parent = self.kept(self.current).parent if self.current is not None else None
        if parent is None:
            raise LceError("nothing to undo: the model came from no other")
        return self.with_current(parent)

    def make_place(self) -> None:
        """Make the folder of its files. Raises LceError if that fails."""
        try:
            self.place.mkdir(exist_ok=True)
        except OSError as error:
            raise LceError(f"{self.place}: cannot be made ({error.strerror})") from None

    def save(self) -> None:
        """Write the session beside the runs. Raises LceError if the folder cannot be written."""
        self.make_place()
        content = SessionFile("lce-workbench-1", dict(self.roles), list(self.models), self.current)
        write_atomically(self.place / FILE_NAME, dump(to_builtins(content)))


def load(folder: Path) -> Session:
    """Read the session of a folder, an empty one if it has no file.

    Raises
    ------
    LceError
        If the file is not a session; names the file, the key and the value.
    """
    file = folder / NAME / FILE_NAME
    if not file.exists():
        return Session(folder, {})
    try:
        content = checked(f"{file}: no session of the workbench", read_yaml(file), SessionFile)
    except LceError as error:
        raise LceError(f"{error}; move it away to begin anew") from None
    if content.current not in (None, *(entry.number for entry in content.models)):
        raise LceError(f"{file}: current is {content.current}, which is the number of no model of the session")
    return Session(folder, content.roles, tuple(content.models), content.current)


def is_run(path: Path) -> bool:
    """Whether a path looks like a run: a bag folder, an MCAP file or a CSV."""
    if path.is_dir():
        return (path / "metadata.yaml").exists() or any(path.glob("*.mcap"))
    return path.suffix.lower() in (".mcap", ".csv")


def find_runs(folder: Path, depth: int = 4) -> dict[str, Path]:
    """Paths that look like runs in a folder and below it, by their path from there; links out of it are left out.

    So are folders that may not be read.
    """
    root = folder.resolve()
    found: dict[str, Path] = {}

    def look(place: Path, left: int) -> None:
        try:
            entries = sorted(place.iterdir())
        except OSError:
            return
        for path in entries:
            if path.name.startswith(".") or path == root / NAME or not path.resolve().is_relative_to(root):
                continue
            if is_run(path):
                found[printable(path.relative_to(root).as_posix())] = path
            elif path.is_dir() and left:
                look(path, left - 1)

    look(root, depth)
    return found


def folder_and_roles(paths: Sequence[Path]) -> tuple[Path, dict[str, Role]]:
    """The folder of the page; if single runs are named, also the role of each run in it.

    Parameters
    ----------
    paths : one folder, whose runs keep the roles that they have; or runs, which are learnt from, all others beside
        them being left aside.
    """
    places = [path.resolve() for path in paths]
    if len(places) == 1 and places[0].is_dir() and not is_run(places[0]):
        return places[0], {}
    folder = Path(os.path.commonpath([place.parent for place in places]))
    return folder, {name: "train" if path.resolve() in places else "off" for name, path in find_runs(folder).items()}
