# SPDX-License-Identifier: Apache-2.0
"""Rows of text as columns on the terminal."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lce_report import Table


def table(rows: Sequence[Sequence[str]], left: int = 0) -> str:
    """The rows under each other, the first ``left`` columns flush left, the others flush right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )


def as_text(found: Table, without: Collection[str] = ()) -> str:
    """A table of the report with its title and its columns, but those ``without``; numbers are flush right."""
    kept = [i for i, name in enumerate(found.head) if name not in without]
    widths = {i: max(len(row[i]) for row in (found.head, *found.rows)) for i in kept}
    numeric = found.numeric
    lines = [
        "  ".join(row[i].rjust(widths[i]) if numeric[i] else row[i].ljust(widths[i]) for i in kept).rstrip()
        for row in (found.head, *found.rows)
    ]
    return "\n".join([found.title, *lines] if found.title else lines)
