# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers out of a text table: parsed block by block, and no cell is kept as a string.

Polars parses a block. A block that it refuses, or that holds a number which is not finite, is read again cell by cell:
that names the row and the cell, or finds that the cells were only padded with blanks.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, TextIO

import numpy as np
from numpy.typing import NDArray

from lce_data.errors import LceError

Floats = NDArray[np.float64]

BLOCK: Final = 1 << 21
"""Characters that are parsed at once: 8 million, a quarter of a million rows of the bench."""


@dataclass(frozen=True)
class TableFormat:
    """How a text table is written.

    Parameters
    ----------
    names : the columns in their order.
    first_row : line of the file, from 1, that holds the first row of numbers.
    separator : one character; a blank stands for any number of blanks and tabs.
    decimal : the decimal sign.
    encoding : of the text.
    missing : words in the place of a sample that is not there.
    readers : how a cell of a column becomes a number, for columns that do not hold numbers; it raises ValueError.
    """

    names: tuple[str, ...]
    first_row: int = 2
    separator: str = ","
    decimal: str = "."
    encoding: str = "utf-8-sig"
    missing: tuple[str, ...] = ()
    readers: Mapping[str, Callable[[str], float]] = field(default_factory=dict)


def read_columns(path: Path, table: TableFormat, wanted: Sequence[str] | None = None) -> dict[str, Floats]:
    """Read columns of a table.

    Parameters
    ----------
    wanted : names of the columns to read; all of them if None.

    Returns
    -------
    dict[str, Floats]
        (n,) of each column, NaN where a cell is empty. Blank lines are no rows.

    Raises
    ------
    LceError
        If the file cannot be read, or a cell is not a finite number; names the file, the row and the cell.
    """
    wanted = table.names if wanted is None else wanted
    parts: dict[str, list[Floats]] = {name: [np.empty(0)] for name in wanted}
    try:
        with path.open(encoding=table.encoding) as file:
            for row, text in _blocks(file, table.first_row):
                text = _single_blanks(text) if table.separator == " " else text
                columns = _parsed(text, table, wanted) or _by_cell(path, row, text, table, wanted)
                for name, values in columns.items():
                    parts[name].append(values)
    except OSError as error:
        raise LceError(f"{path}: {error.strerror}") from None
    except (UnicodeError, csv.Error):
        raise LceError(f"{path}: not a CSV text file") from None
    return {name: np.concatenate(parts.pop(name)) for name in wanted}  # popped, so that no column is held twice


def _blocks(file: TextIO, first_row: int) -> Iterator[tuple[int, str]]:
    """Whole lines of a file, many at once, and the number of the first of them."""
    row = first_row
    for _ in range(first_row - 1):
        file.readline()
    while text := file.read(BLOCK) + file.readline():
        yield row, text
        row += text.count("\n")


def _parsed(text: str, table: TableFormat, wanted: Sequence[str]) -> dict[str, Floats] | None:
    """The columns of a block as Polars parses them; None if it cannot, or a number is not finite."""
    if table.separator == table.decimal or table.readers.keys() & set(wanted):
        return None
    import polars as pl

    text = re.sub(r"\n\n+", "\n", text.lstrip("\n")) if "\n\n" in text or text.startswith("\n") else text
    try:
        frame = pl.read_csv(
            text.encode(),
            has_header=False,
            schema={name: pl.Float64 if name in wanted else pl.String for name in table.names},
            columns=sorted(table.names.index(name) for name in wanted),
            separator=table.separator,
            null_values=list(table.missing),
            decimal_comma=table.decimal == ",",
            raise_if_empty=False,
        )
    except pl.exceptions.PolarsError:
        return None
    if frame.height != text.count("\n") + (not text.endswith("\n")):  # a quoted cell of several lines
        return None
    columns = {name: frame[name].to_numpy() for name in wanted}
    finite = all(np.isfinite(columns[name]).sum() == frame.height - frame[name].null_count() for name in wanted)
    return columns if finite else None


def _by_cell(path: Path, row: int, text: str, table: TableFormat, wanted: Sequence[str]) -> dict[str, Floats]:
    """The columns of a block, cell by cell. Raises LceError for the first cell that is not a finite number."""
    reader = csv.reader(io.StringIO(text), delimiter=table.separator)
    rows = [(row - 1 + reader.line_num, cells) for cells in reader if any(cells)]
    width = len(table.names)
    for i, cells in rows:
        if len(cells) > width:
            hint = "; a decimal comma?" if table.separator == "," else ""
            raise LceError(f"{path}, row {i}: {len(cells)} cells under a header of {width}{hint}")
    columns = {}
    for name in wanted:
        k = table.names.index(name)
        cells_of = ((i, cells[k].strip() if k < len(cells) else "") for i, cells in rows)
        columns[name] = np.array([_number(f"{path}, row {i}: {name}", cell, table, name) for i, cell in cells_of])
    return columns


def _number(where: str, cell: str, table: TableFormat, name: str) -> float:
    """The number of a cell, NaN if it is empty."""
    if not cell or cell in table.missing:
        return math.nan
    reader = table.readers.get(name)
    try:
        number = reader(cell) if reader else float(cell.replace(",", ".") if table.decimal == "," else cell)
    except ValueError:
        raise LceError(f"{where} is {cell!r}, not a number") from None
    if not math.isfinite(number):
        raise LceError(f"{where} is {cell}")
    return number


def _single_blanks(text: str) -> str:
    """The lines with one blank between cells, and none at either end."""
    return re.sub(r"(?m)^ | $", "", re.sub(r"[ \t]+", " ", text))
