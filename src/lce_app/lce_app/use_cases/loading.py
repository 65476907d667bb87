# SPDX-License-Identifier: Apache-2.0
"""Runs for a use case: read, and what looks wrong about them said at once, before anything slow begins."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from lce_data.read_runs import read_runs
from lce_data.run import Run
from lce_data.suspicions import suspicions

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
