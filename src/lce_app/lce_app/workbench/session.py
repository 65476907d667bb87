# SPDX-License-Identifier: Apache-2.0
"""What the user of the workbench decided, kept in ``FOLDER/workbench/``: roles of runs, models, and which is current.

A model is a numbered file that is never changed; undo goes back to the one that it came from.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal, get_args

import yaml

from lce_data.errors import LceError

Role = Literal["train", "test", "off"]
NAME: Final = "workbench"
FORMAT: Final = "lce-workbench-1"


@dataclass(frozen=True)
class Kept:
    """A model of the history: its number, how it came about, the number of the one that it came from, and the command
    that does the same.
    """

    number: int
    how: str
    parent: int | None = None
    command: str = ""


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

    def kept(self, number: int) -> Kept:
        """A model of the history; LceError where there is none of that number."""
        for entry in self.models:
            if entry.number == number:
                return entry
        raise LceError(f"{self.place}: there is no model {number}")

    def names(self, role: Role) -> tuple[str, ...]:
        """Runs of one role."""
        return tuple(name for name, r in self.roles.items() if r == role)

    def with_role(self, name: str, role: Role) -> Session:
        """A run to learn from, to hold out, or to leave aside."""
        return replace(self, roles={**self.roles, name: role})

    def next_number(self) -> int:
        """Number of the next model."""
        return 1 + max((entry.number for entry in self.models), default=0)

    def with_model(self, how: str, parent: int | None, command: str = "") -> Session:
        """The model whose file has the next number joins the history and is current."""
        entry = Kept(self.next_number(), how, parent, command)
        return replace(self, models=(*self.models, entry), current=entry.number)

    def with_current(self, number: int) -> Session:
        """Another model of the history is current."""
        return replace(self, current=self.kept(number).number)

    def undone(self) -> Session:
        """The model that the current one came from is current again; LceError where it came from none."""
        parent = self.kept(self.current).parent if self.current is not None else None
        if parent is None:
            raise LceError("nothing to undo: the model came from no other")
        return self.with_current(parent)

    def make_place(self) -> None:
        """Make the folder of its files; LceError where that cannot be."""
        try:
            self.place.mkdir(exist_ok=True)
        except OSError as error:
            raise LceError(f"{self.place}: cannot be made ({error.strerror})") from None

    def save(self) -> None:
        """Write it beside the runs; LceError where nothing can be written."""
        from lce_data.files import write_atomically

        self.make_place()
        content = {
            "format": FORMAT,
            "roles": dict(self.roles),
            "models": [asdict(entry) for entry in self.models],
            "current": self.current,
        }
        write_atomically(self.place / "session.yaml", yaml.safe_dump(content, sort_keys=False, allow_unicode=True))


def load(folder: Path) -> Session:
    """The session of a folder, empty where it has none; LceError where its file is not one."""
    file = folder / NAME / "session.yaml"
    if not file.exists():
        return Session(folder, {})
    try:
        content: Any = yaml.safe_load(file.read_text(encoding="utf-8"))
        if content["format"] != FORMAT or not set(content["roles"].values()) <= set(get_args(Role)):
            raise KeyError
        models = tuple(Kept(**entry) for entry in content["models"])
        found = Session(folder, content["roles"], models, content["current"])
        if found.current is not None:
            found.kept(found.current)
        return found
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, AttributeError):
        raise LceError(f"{file}: no session of the workbench; move it away to begin anew") from None


def is_run(path: Path) -> bool:
    """Does it look like a run: a bag folder, an MCAP file, a CSV?"""
    if path.is_dir():
        return (path / "metadata.yaml").exists() or any(path.glob("*.mcap"))
    return path.suffix.lower() in (".mcap", ".csv")


def find_runs(folder: Path, depth: int = 4) -> dict[str, Path]:
    """What looks like a run in a folder and below it, by its path from there; nothing that a link leads out to."""
    root = folder.resolve()
    found: dict[str, Path] = {}

    def look(place: Path, left: int) -> None:
        for path in sorted(place.iterdir()):
            if path.name.startswith(".") or path == root / NAME or not path.resolve().is_relative_to(root):
                continue
            if is_run(path):
                found[path.relative_to(root).as_posix()] = path
            elif path.is_dir() and left:
                look(path, left - 1)

    look(root, depth)
    return found
