# SPDX-License-Identifier: Apache-2.0
"""What a use case begins with: runs, with a warning of what looks wrong in them, a model, and effects beside it."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from lce_data.errors import LceError
from lce_data.read_runs import read_runs
from lce_data.run import Run
from lce_data.suspicions import suspicions
from lce_model import Model, load_model
from lce_model.effects import Effect, find

LOG: Final = logging.getLogger(__name__)


def load_runs(files: Sequence[Path]) -> tuple[Run, ...]:
    """Read runs, and log a warning with its cure for each thing that looks wrong about them.

    Parameters
    ----------
    files : bag folders, MCAP files or CSV files.

    Raises
    ------
    LceError
        If a run cannot be used.
    """
    runs = read_runs(files)
    for run in runs:
        for sentence in suspicions(run):
            LOG.warning("lce: warning: %s", sentence)
    return runs


def load_runs_and_tests(files: Sequence[Path], tests: Sequence[Path]) -> tuple[tuple[Run, ...], tuple[Run, ...]]:
    """Read the runs to learn from and those held out, which have other names.

    Raises
    ------
    LceError
        If a run cannot be used, or is both learnt from and held out.
    """
    every = load_runs([*files, *tests])
    runs, held_out = every[: len(files)], every[len(files) :]
    known = {run.sha256: run for run in runs if run.sha256}
    for run in held_out:
        if run.sha256 in known:
            raise LceError(
                f"{run.path}: is held out, and learnt from as {known[run.sha256].path}; leave it out of one of the two"
            )
    return runs, held_out


def load_model_and_effects(file: Path, named: Iterable[str]) -> tuple[Model, list[Effect]]:
    """Read a model and the effects that the user named beside it. Their files run, so the model may list them.

    Raises
    ------
    LceError
        If the model or an effect cannot be used.
    """
    effects = [find(name) for name in named]
    return load_model(file), effects
