# SPDX-License-Identifier: Apache-2.0
"""The user's decisions in the workbench, in ``FOLDER/workbench/``.

They are the role of each run, its recipe, the models, and which of them is the current one. A model is a numbered file
that is never changed, and so is a prepared run, whose folder is named by its recipe.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from msgspec import Struct, to_builtins

from lce_data.errors import LceError
from lce_data.files import name_of, printable, write_atomically
from lce_data.schema import checked, read_yaml
from lce_data.yaml_text import dump

if TYPE_CHECKING:  # the page comes first: without a recipe NumPy is not needed for it
    from lce_data.preparing.recipe import Recipe

Role = Literal["train", "test", "off"]
DEEPEST: Final = 4
"""Folders below that of the page in which runs are looked for."""
NAME: Final = "workbench"
FILE_NAME: Final = "session.yaml"


class Kept(Struct, frozen=True, forbid_unknown_fields=True):
    """A model of the history: its number, how it came about, its parent's number, and the command that makes it."""

    number: int
    how: str
    parent: int | None = None
    command: str = ""


class SessionFile(Struct, frozen=True):
    """The content of ``session.yaml``: role and recipe of each run by its path, models, the current one's number."""

    format: Literal["lce-workbench-1"]
    roles: dict[str, Role]
    models: list[Kept]
    current: int | None
    recipes: dict[str, list[Any]] = {}


@dataclass(frozen=True)
class Decisions:
    """What the user can undo: the roles and the recipes of the runs, and which model is the current one."""

    roles: Mapping[str, Role]
    recipes: Mapping[str, Recipe]
    current: int | None


@dataclass(frozen=True)
class Session:
    """An immutable state of the page. Runs are named by their paths in ``folder``."""

    folder: Path
    roles: Mapping[str, Role]
    models: tuple[Kept, ...] = ()
    current: int | None = None
    recipes: Mapping[str, Recipe] = field(default_factory=dict)

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

    @property
    def own_effects(self) -> Path:
        """Folder of the effect files that the user brought."""
        return self.place / "effects"

    @property
    def uploads(self) -> Path:
        """Folder of files from elsewhere, in which no run is looked for."""
        return self.place / "uploads"

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

    def recipe(self, name: str) -> Recipe:
        """The steps by which a run is prepared; none for a run that is used as it was recorded."""
        return self.recipes.get(name, ())

    def with_recipe(self, name: str, recipe: Recipe) -> Session:
        """The same session, with other steps for a run."""
        others = {key: steps for key, steps in self.recipes.items() if key != name}
        return replace(self, recipes={**others, name: recipe} if recipe else others)

    def prepared_file(self, name: str, path: Path, recipe: Recipe) -> Path:
        """Where the run of a path is kept, prepared by a recipe: another recipe has another folder."""
        digest = hashlib.sha256(dump([name, _plain(recipe)]).encode()).hexdigest()[:8]
        return self.prepared / digest / f"{name_of(path)}.csv"

    @property
    def prepared(self) -> Path:
        """Folder of the prepared runs."""
        return self.place / "prepared"

    @property
    def decisions(self) -> Decisions:
        """What the user can undo."""
        return Decisions(self.roles, self.recipes, self.current)

    def decided(self, decisions: Decisions) -> Session:
        """The same runs and models with other decisions; what has come since then keeps its role."""
        roles = {name: decisions.roles.get(name, role) for name, role in self.roles.items()}
        return replace(self, roles=roles, recipes=decisions.recipes, current=decisions.current)

    def make_place(self) -> None:
        """Make the folder of its files. Raises LceError if that fails."""
        try:
            self.place.mkdir(exist_ok=True)
        except OSError as error:
            raise LceError(f"{self.place}: cannot be made ({error.strerror})") from None

    def save(self) -> None:
        """Write the session beside the runs. Raises LceError if the folder cannot be written."""
        self.make_place()
        content = {
            "format": "lce-workbench-1",
            "roles": dict(self.roles),
            "models": to_builtins(self.models),
            "current": self.current,
        }
        if self.recipes:
            content["recipes"] = {name: _plain(recipe) for name, recipe in self.recipes.items()}
        write_atomically(self.place / FILE_NAME, dump(content))


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
    return Session(folder, content.roles, tuple(content.models), content.current, _recipes(file, content))


def _recipes(file: Path, content: SessionFile) -> dict[str, Recipe]:
    """The recipes of a session file. Raises LceError that names the run and the step."""
    if not content.recipes:
        return {}
    from lce_data.preparing.recipe import Recipe

    return {name: checked(f"{file}: recipe of {name}", steps, Recipe) for name, steps in content.recipes.items()}


def _plain(recipe: Recipe) -> list[dict[str, Any]]:
    from lce_data.preparing.recipe import plain

    return plain(recipe)


def is_run(path: Path) -> bool:
    """Whether a path looks like a run: a bag folder, an MCAP file or a CSV."""
    if path.is_dir():
        return (path / "metadata.yaml").exists() or any(path.glob("*.mcap"))
    return path.suffix.lower() in (".mcap", ".csv")


def find_runs(folder: Path, depth: int = DEEPEST) -> dict[str, Path]:
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

    Raises
    ------
    LceError
        If one of several paths is no run.
    """
    places = [path.resolve() for path in paths]
    if len(places) == 1 and places[0].is_dir() and not is_run(places[0]):
        return places[0], {}
    folder = Path(os.path.commonpath([place.parent for place in places]))
    runs = {name: path.resolve() for name, path in find_runs(folder).items()}
    for path in paths:
        if path.resolve() not in runs.values():
            raise LceError(f"{path}: is no run, or more than {DEEPEST} folders below {folder}")
    return folder, {name: "train" if path in places else "off" for name, path in runs.items()}


def from_folder(files: Sequence[Path], folder: Path) -> list[str]:
    """Ways from a folder to files, sorted: those of other runs, or of the same prepared in another way, are others."""
    return sorted(os.path.relpath(file, folder) for file in files)
