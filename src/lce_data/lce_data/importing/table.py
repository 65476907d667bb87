# SPDX-License-Identifier: Apache-2.0
"""A foreign text table as signals: which column holds what, by hand or by its header, and in which unit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import Unit
from lce_data.columns import read_columns
from lce_data.errors import LceError
from lce_data.importing.headers import SI_UNITS, TIME, Meaning, meaning, si_unit
from lce_data.importing.layout import Layout, find_layout
from lce_data.importing.plausible import Hints, likely_unit, response_time
from lce_data.importing.recording import COLUMN, UNIT, Pick, Recording, Signal
from lce_data.importing.units import find_unit, unit_and_sign

Floats = NDArray[np.float64]

DAY_S: Final = 86400.0


def read_table(path: Path, picks: Sequence[Pick] = ()) -> Recording:
    """Understand a text table.

    Parameters
    ----------
    picks : what the user said; other quantities are looked for among the headers.

    Returns
    -------
    Recording
        The time and a signal for each channel that was found.

    Raises
    ------
    LceError
        If the file is no table of numbers, has no time, a cell is not a number, or a picked column is not there.
    """
    layout = find_layout(path)
    by_hand = {pick.quantity: _picked(path, layout, pick) for pick in picks if pick.source}
    found, rivals = _by_header(layout, {pick.quantity for pick in picks}, set(by_hand.values()))
    columns = {**by_hand, **{quantity: name for quantity, (name, _) in found.items()}}
    if TIME not in columns:
        raise LceError(f"{path}: no column looks like a time; --column time=NAME:UNIT names it: {_listed(layout)}")
    columns = {**{quantity: columns[quantity] for quantity in SI_UNITS if quantity in columns}, **columns}  # time first
    raw, rows_changed = _read_rows(path, layout, columns)
    hints = _hints(raw[TIME], raw.get("temperature"))
    typed = {pick.quantity: pick.unit for pick in picks}
    signals: list[Signal] = []
    for quantity, value in raw.items():
        name = columns[quantity]
        said = found[quantity][1] if quantity in found else _said(name, quantity)
        about = replace(hints, header=name)
        unit, sign, known = _unit(quantity, typed.get(quantity, ""), said, name in layout.dated, value, about)
        guessed = (COLUMN,) * (quantity in found and (not found[quantity][1].certain or quantity in rivals))
        guessed += () if known else (UNIT,)
        time_s = unit.to_si(value - value[0]) if quantity == TIME else signals[0].time_s
        signals.append(Signal(quantity, name, unit, sign, guessed, time_s, value))
    left_out = tuple(
        f"{name} (may be the {rival} as well)" if (rival := _rival(name, rivals)) else name
        for name in layout.table.names
        if name not in (signal.source for signal in signals)
    )
    return Recording(path, tuple(signals), left_out, rows_changed, layout.notes)


def _read_rows(path: Path, layout: Layout, columns: dict[str, str]) -> tuple[dict[str, Floats], tuple[str, ...]]:
    """Values (n,) as in the file of each quantity that has any, the time first, and a sentence on rows put together."""
    read = read_columns(path, layout.table, [*columns.values()])
    filled = np.any([np.isfinite(values) for values in read.values()], axis=0)  # spreadsheets end with rows of commas
    raw = {q: _only(read[name], filled) for q, name in columns.items() if np.isfinite(read[name]).any()}
    if TIME not in raw:
        raise LceError(f"{path}: the column {columns[TIME]!r}, taken for the time, is empty")
    if columns[TIME] in layout.dated:
        raw[TIME] = _past_midnight(raw[TIME])
    _check_time(path, raw[TIME], layout.table.first_row)
    first = np.append(True, np.diff(raw[TIME]) > 0.0)
    if first.all():
        return raw, ()
    remark = (
        f"{int(np.sum(~first))} of {first.size} rows repeat the time of the row before; "
        "of each column, the last value at a time is kept"
    )
    row = np.cumsum(first) - 1
    return {quantity: _last_of_each(values, row) for quantity, values in raw.items()}, (remark,)


def _last_of_each(values: Floats, row: NDArray[np.intp]) -> Floats:
    """The last of the values (n,) that are there for each row (n,) of the result; NaN if there is none."""
    last, there = np.full(int(row[-1]) + 1, np.nan), np.isfinite(values)
    last[row[there]] = values[there]  # of several values for one place numpy keeps the last
    return last


def _hints(time: Floats, temperature: Floats | None) -> Hints:
    """What the temperature tells of the units of other columns."""
    if temperature is None:
        return Hints()
    warming = float(np.nanmax(temperature) - np.nanmin(temperature))
    return Hints(warming=warming, response=response_time(time, temperature))


def _picked(path: Path, layout: Layout, pick: Pick) -> str:
    """The column that a user named, or gave the number of."""
    names = layout.table.names
    near = [name for name in names if name.casefold() == pick.source.casefold()]
    if pick.source in names or near:
        name = pick.source if pick.source in names else near[0]
    elif pick.source.isdigit() and 0 < int(pick.source) <= len(names):
        name = names[int(pick.source) - 1]
    else:
        raise LceError(f"{path}: no column {pick.source!r}; it has {_listed(layout)}")
    if name in layout.unread:
        raise LceError(f"{path}: column {name!r} holds text, not numbers")
    return name


def _by_header(
    layout: Layout, said: set[str], taken: set[str]
) -> tuple[dict[str, tuple[str, Meaning]], dict[str, list[str]]]:
    """The column of each quantity of which the user said nothing, and others that may hold it as well."""
    candidates: dict[str, list[tuple[str, Meaning]]] = {}
    for name in layout.table.names:
        what = Meaning(TIME, None, True) if name in layout.dated else meaning(name)
        if what is not None and what.quantity not in said and name not in taken and name not in layout.unread:
            candidates.setdefault(what.quantity, []).append((name, what))
    found, rivals = {}, {}
    for quantity, columns in candidates.items():
        best = [column for column in columns if column[1].certain] or columns
        found[quantity] = best[0]
        if len(best) > 1 and quantity != TIME:
            rivals[quantity] = [name for name, _ in best[1:]]
    return found, rivals


def _only(values: Floats, rows: NDArray[np.bool_]) -> Floats:
    """The values in some rows; not copied if these are all."""
    return values if rows.all() else values[rows]


def _past_midnight(time: Floats) -> Floats:
    """Times (n,) of day that go on over midnight; dates as they are."""
    if np.nanmax(time) > DAY_S:
        return time
    return time + DAY_S * np.concatenate([[0.0], np.cumsum(np.diff(time) < -0.5 * DAY_S)])


def _check_time(path: Path, time: Floats, first_row: int) -> None:
    """Raise LceError if the time (n,) goes back or is missing."""
    if np.isnan(time).any():
        raise LceError(f"{path}, row {first_row + int(np.argmax(np.isnan(time)))}: the time is empty")
    steps = np.diff(time)
    if (steps < 0.0).any():
        i = int(np.argmax(steps < 0.0))
        raise LceError(
            f"{path}, row {first_row + i + 1}: the time goes back, from {time[i]:g} to {time[i + 1]:g}; "
            "are these several runs in one file? Split it there"
        )


def _said(name: str, quantity: str) -> Meaning | None:
    """What the header of a column that a user picked says, if it is about the same quantity."""
    what = meaning(name)
    return what if what is not None and what.quantity == quantity else None


def _unit(
    quantity: str, typed: str, said: Meaning | None, dated: bool, values: Floats, hints: Hints
) -> tuple[Unit, float, bool]:
    """Unit and sign of a column, and whether somebody said so: the user, the header, or a date itself."""
    if typed:
        return *unit_and_sign(si_unit(quantity), typed), True
    if dated:
        second = find_unit("s", "s")
        assert second is not None
        return second, 1.0, True
    if said is not None and said.unit is not None:
        return said.unit, 1.0, True
    return likely_unit(quantity, values, hints), 1.0, not si_unit(quantity)


def _rival(name: str, rivals: dict[str, list[str]]) -> str:
    return next((quantity for quantity, names in rivals.items() if name in names), "")


def _listed(layout: Layout) -> str:
    return ", ".join(layout.table.names)
