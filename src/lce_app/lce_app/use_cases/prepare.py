# SPDX-License-Identifier: Apache-2.0
"""Prepare runs by a recipe: cut, detrend, resample, merge. The recordings stay as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lce_data.errors import LceError
from lce_data.files import name_of
from lce_data.preparing.prepared_run import prepare, write_prepared
from lce_data.preparing.recipe import read_recipe
from lce_data.read_runs import read_recording
from lce_data.suspicions import suspicions


@dataclass(frozen=True)
class Prepared:
    """The file of a prepared run, and what a user should know of it."""

    file: Path
    warnings: tuple[str, ...]


def prepare_runs(files: Sequence[Path], recipe_file: Path, out: Path, overwrite: bool = False) -> list[Prepared]:
    """Write prepared runs, each as NAME.csv with its conditions and its recipe beside it.

    Parameters
    ----------
    files : bag folders, MCAP files or CSV files, each of which gets the same steps.
    recipe_file : the steps; files of merges are named from the folder of each run.
    out : folder of the prepared runs; it is made if need be.
    overwrite : replace files that exist.

    Raises
    ------
    LceError
        If a step makes no sense on a run, or a file exists already or would be written twice. Nothing is written then.

    Examples
    --------
    >>> prepare_runs([Path("runs/pulse.csv")], Path("recipe.yaml"), Path("prepared"))  # doctest: +SKIP
    """
    recipe = read_recipe(recipe_file)
    outs = [out / f"{name_of(file)}.csv" for file in files]
    if twice := {file.name for file in outs if outs.count(file) > 1}:
        raise LceError(f"several runs would be written as {min(twice)}; prepare them into folders of their own")
    found = []
    for file, place in zip(files, outs, strict=True):
        for written in (place, place.with_suffix(".yaml"), place.with_suffix(".recipe.yaml")):
            if written.exists() and not overwrite:
                raise LceError(f"{written}: exists already; --force overwrites it")
        found.append(prepare(read_recording(file), recipe))
    return [
        Prepared(
            write_prepared(made, recipe, place),
            (*(f"{made.run.name}: {said}" for said in made.warnings), *suspicions(made.run)),
        )
        for made, place in zip(found, outs, strict=True)
    ]
