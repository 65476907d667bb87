# SPDX-License-Identifier: Apache-2.0
"""A recipe: steps that prepare a run before it is used. The recording itself stays as it is.

A recipe file is YAML::

    format: lce-recipe-1
    steps:
      - {step: merge, file: displacement.csv, at_s: 0.35}
      - {step: cut, begin_s: 20.0, end_s: 24.5, channels: [temperature]}
      - {step: detrend, channel: displacement, order: line, rest: [[0.0, 5.0], [90.0, 100.0]]}
      - {step: resample, dt_s: 0.05}
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from msgspec import Meta, Struct, to_builtins

from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.preparing.steps import Cut, Detrend, Merge, Resample
from lce_data.run import Run
from lce_data.schema import checked, read_yaml

FORMAT: Final = "lce-recipe-1"
MOST_STEPS: Final = 100

Step = Cut | Detrend | Resample | Merge
Recipe = tuple[Step, ...]


class RecipeFile(Struct, frozen=True, forbid_unknown_fields=True):
    """The content of a recipe file."""

    format: Literal["lce-recipe-1"]
    steps: Annotated[tuple[Step, ...], Meta(max_length=MOST_STEPS)]


def read_recipe(file: Path) -> Recipe:
    """Read a recipe file. Raises LceError that names the file, the key and the value."""
    return checked(file, read_yaml(file), RecipeFile).steps


def write_recipe(file: Path, recipe: Recipe) -> None:
    """Write the file that `read_recipe` reads. Raises LceError if that fails."""
    from lce_data.yaml_text import dump

    write_atomically(file, dump({"format": FORMAT, "steps": plain(recipe)}))


def plain(recipe: Iterable[Step]) -> list[dict[str, Any]]:
    """The steps as plain values, keys without a value left out."""
    return [{k: v for k, v in to_builtins(step).items() if v not in (None, [], ())} for step in recipe]


def prepared(run: Run, recipe: Recipe, others: Mapping[str, Run]) -> tuple[Run, tuple[str, ...]]:
    """Prepare a run; pure.

    Parameters
    ----------
    others : what the files of the merges hold, by the name that the step gives.

    Returns
    -------
    tuple[Run, tuple[str, ...]]
        The run after the last step, and what a user should know of the steps.

    Raises
    ------
    LceError
        If a step makes no sense on the run; names the step.
    """
    said: list[str] = []
    for number, step in enumerate(recipe, start=1):
        said += step.warnings(run)
        try:
            run = step.apply(run, others)
        except LceError as error:
            raise LceError(f"{run.name}: step {number}, {step.words}: {error}") from None
    return run, tuple(dict.fromkeys(said))
