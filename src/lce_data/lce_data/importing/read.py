# SPDX-License-Identifier: Apache-2.0
"""Understand a foreign file, whichever kind it is."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lce_data.errors import LceError
from lce_data.importing.bag import read_bag_topics
from lce_data.importing.recording import Pick, Recording, is_bag
from lce_data.importing.table import read_table


def read_foreign(path: Path, columns: Sequence[Pick] = (), topics: Sequence[Pick] = ()) -> Recording:
    """Understand a text table, or chosen topics of a bag.

    Raises LceError if the file does not exist or cannot be understood; names the column, the row or the topic.
    """
    if not path.exists():
        raise LceError(f"{path}: no such file or folder")
    return read_bag_topics(path, topics) if is_bag(path) else read_table(path, columns)
