# SPDX-License-Identifier: Apache-2.0
"""How a foreign text table is written: encoding, separator, decimal sign, header, and cells that are no numbers."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from lce_data.columns import BLOCK, TableFormat
from lce_data.errors import LceError
from lce_data.files import check_regular
from lce_data.importing.units import SPELLINGS, find_unit
from lce_data.run_csv import note

HEAD_LINES: Final = 200
SEPARATORS: Final = ("\t", ";", "|", ",", " ")
"""In the order in which they are tried: with a semicolon, a comma is a decimal sign."""
SWITCH: Final = {"true": 1.0, "false": 0.0, "on": 1.0, "off": 0.0, "yes": 1.0, "no": 0.0}
DATES: Final = (
    "%d.%m.%Y %H:%M:%S", "%d.%m.%Y %H:%M:%S.%f", "%m/%d/%Y %H:%M:%S", "%m/%d/%Y %H:%M:%S.%f", "%m/%d/%Y %H:%M",
    "%Y/%m/%d %H:%M:%S", "%Y/%m/%d %H:%M:%S.%f", "%d.%m.%Y %H:%M",
)  # fmt: skip
"""Forms of dates beside ISO 8601."""
MISSING: Final = ("NaN", "nan", "NAN", "NA", "N/A", "n/a", "#N/A", "null", "NULL", "None", "-", "--")
"""Words for a sample that is not there."""
THOUSANDS: Final = r"[+-]?[1-9]\d{0,2}([.,]\d{3})+"
CLOCK: Final = r"\d{1,3}:\d\d:\d\d(?:[.,]\d+)?"


@dataclass(frozen=True)
class Layout:
    """A text table: how it is written, and what its first lines hold.

    Parameters
    ----------
    dated : columns whose cells are dates or times of day, read as seconds.
    switched : columns whose cells are words such as on and off, read as 1 and 0.
    unread : columns that hold other text.
    notes : what the lines ``# key: value`` in front of the header say.
    """

    table: TableFormat
    dated: frozenset[str]
    switched: frozenset[str]
    unread: frozenset[str]
    notes: dict[str, Any]


def find_layout(path: Path) -> Layout:
    """Find out how a table is written, from its first lines. Raises LceError if there is no row of numbers in them."""
    encoding, lines = _first_lines(path)
    separator = _separator(lines)
    rows = [_cells(line, separator) for line in lines]
    first = _first_row(path, rows)
    names = _names(rows, lines, first, separator)
    body = [row for row in rows[first:] if any(row)]
    columns = {
        name: [row[i] for row in body if i < len(row) and row[i] not in ("", *MISSING)] for i, name in enumerate(names)
    }
    decimal = _decimal(path, [cell for cells in columns.values() for cell in cells if _is_number(cell)])
    readers: dict[str, Callable[[str], float]] = {}
    dated, switched, unread = set(), set(), set()
    for name, cells in columns.items():
        if 2 * sum(_is_number(cell) for cell in cells) >= len(cells):  # a cell that is none is told when it is read
            continue
        if len(set(cells)) == 1 < len(cells):  # such as a date beside a time of day: nothing to read
            unread.add(name)
        elif reader := _date_reader(cells):
            dated.add(name)
            readers[name] = reader
        elif all(cell.casefold() in SWITCH for cell in cells):
            switched.add(name)
            readers[name] = _switch
        else:
            unread.add(name)
    table = TableFormat(tuple(names), first + 1, separator, decimal, encoding, MISSING, readers)
    notes = {key: value for line in lines[:first] if line.startswith("#") for key, value in note(line).items()}
    return Layout(table, frozenset(dated), frozenset(switched), frozenset(unread), notes)


def _first_lines(path: Path) -> tuple[str, list[str]]:
    """The encoding, by which the whole file can be read, and the first lines without their ends."""
    try:
        check_regular(path)
        with path.open("rb") as file:
            start = file.read(4)
        utf16 = start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        for encoding in ("utf-16",) if utf16 else ("utf-8-sig", "cp1252"):
            with suppress(UnicodeError), path.open(encoding=encoding) as opened:
                lines = [line.rstrip("\n") for line, _ in zip(opened, range(HEAD_LINES), strict=False)]
                while opened.read(BLOCK):
                    pass
                if not any("\0" in line for line in lines):
                    return encoding, lines
    except OSError as error:
        raise LceError(f"{path}: {error.strerror}") from None
    raise LceError(f"{path}: not a text table; a spreadsheet has to be saved as CSV first")


def _separator(lines: Sequence[str]) -> str:
    """The first separator by which most of the last lines have the same number of cells, two or more."""
    body = [line for line in lines if line.strip() and not line.startswith("#")]
    body = body[len(body) // 2 :]
    for separator in SEPARATORS:
        widths = [len(_cells(line, separator)) for line in body]
        if widths and max(widths) > 1 and widths.count(max(widths)) > 0.8 * len(widths):
            return separator
    return ","


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]
    except csv.Error:  # a line of 100 kB, as of a web page
        return []


def _first_row(path: Path, rows: Sequence[Sequence[str]]) -> int:
    """Index of the first row of numbers."""
    width = max((len(row) for row in rows[len(rows) // 2 :]), default=0)
    for i, row in enumerate(rows):
        numbers = sum(_is_number(cell) for cell in row)
        words = sum(bool(cell) and not (_is_number(cell) or _is_word_of_data(cell)) for cell in row)
        if numbers and len(row) == width > 1 and numbers >= words and not row[0].startswith("#"):
            return i
    raise LceError(
        f"{path}: no table of numbers: no row of its first {len(rows)} lines holds two columns with a number"
    )


def _names(rows: Sequence[Sequence[str]], lines: Sequence[str], first: int, separator: str) -> list[str]:
    """A name for each column: from the line above the first row, or of two lines if the second one holds units."""
    width = len(rows[first])
    above = [i for i in range(first) if lines[i].strip()][-2:]
    heads = [_cells(lines[i].lstrip("#%").strip(), separator) for i in above]
    heads = [_padded(head, rows[first:], width) for head in heads]
    heads = [head for head in heads if len(head) == width and not all(_is_number(cell) for cell in head if cell)]
    if len(heads) == 2 and not all(_is_unit(cell) for cell in heads[1]):
        heads = heads[1:]
    if len(heads) == 2:
        units = [cell.strip("[]()") for cell in heads[1]]
        names = [f"{name} [{unit}]" if unit else name for name, unit in zip(heads[0], units, strict=True)]
    else:
        names = list(heads[0]) if heads else [""] * width
    names = [name or f"column {i + 1}" for i, name in enumerate(names)]
    return [name if names.index(name) == i else f"{name} ({i + 1})" for i, name in enumerate(names)]


def _is_unit(cell: str) -> bool:
    text = cell.strip("[]()")
    return text in ("", "-", "1") or any(find_unit(si_unit, text) for si_unit in SPELLINGS)


def _padded(head: list[str], body: Sequence[Sequence[str]], width: int) -> list[str]:
    """A header that lacks a cell: of a separator at the end of each row, or of row names in front of it."""
    if len(head) != width - 1:
        return head
    return [*head, ""] if not any(row[-1] for row in body if len(row) == width) else ["", *head]


def _is_number(cell: str) -> bool:
    return re.fullmatch(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?", cell) is not None


def _decimal(path: Path, numbers: Sequence[str]) -> str:
    """The decimal sign of numbers. Raises LceError if commas or points among them separate thousands, as it seems."""
    commas, points = ([cell for cell in numbers if sign in cell] for sign in ",.")
    for cells in (commas, points):
        if commas and points and all(re.fullmatch(THOUSANDS, cell) for cell in cells):
            raise LceError(
                f"{path}: it holds {commas[0]!r} and {points[0]!r}, so {cells[0]!r} may have a separator of thousands; "
                "save the table without such separators"
            )
    return "," if commas else "."


def _is_word_of_data(cell: str) -> bool:
    """Whether a cell is no number and yet not a header."""
    return cell.casefold() in SWITCH or re.match(r"\d{1,4}[-./:]\d{1,2}[-./:]\d", cell) is not None


def _switch(cell: str) -> float:
    try:
        return SWITCH[cell.casefold()]
    except KeyError:
        raise ValueError(cell) from None


def _date_reader(cells: Sequence[str]) -> Callable[[str], float] | None:
    """What makes seconds of such dates or times of day; None if they are neither."""
    if cells and all(re.fullmatch(CLOCK, cell) for cell in cells):
        return _clock
    for read in (_iso, *(lambda cell, form=form: _since_1970(datetime.strptime(cell, form)) for form in DATES)):
        with suppress(ValueError):
            for cell in cells:
                read(cell)
            return read if cells else None
    return None


def _clock(cell: str) -> float:
    hours, minutes, seconds = cell.replace(",", ".").split(":")
    return 3600.0 * int(hours) + 60.0 * int(minutes) + float(seconds)


def _iso(cell: str) -> float:
    return _since_1970(datetime.fromisoformat(cell))


def _since_1970(date: datetime) -> float:
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()
