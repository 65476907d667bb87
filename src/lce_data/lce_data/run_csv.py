# SPDX-License-Identifier: Apache-2.0
"""A run as a CSV file: ``time_s`` and a column for each channel, ``time_s,power_w,temperature_c,displacement_m``.

A cell is empty if the sensor has no sample at that time. Columns of channels that were not measured are left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import CHANNELS, Channel
from lce_data.errors import LceError
from lce_data.files import read_csv_rows, write_atomically

Floats = NDArray[np.float64]

COLUMNS: Final = ("time_s", *(channel.column for channel in CHANNELS))


def write_run_csv(path: Path, time_s: Floats, values: Mapping[Channel, Floats]) -> None:
    """Write a run.

    Parameters
    ----------
    time_s : (n,) [s], strictly increasing.
    values : (n,) of each channel [its SI unit], NaN where it has no sample.

    Raises
    ------
    LceError
        If the time does not increase or the file cannot be written.
    """
    _check_time(path, time_s)
    columns = {"time_s": [f"{t:.9g}" for t in time_s.tolist()]}
    for channel in (c for c in CHANNELS if c in values):
        recorded = channel.recorded.from_si(values[channel]).tolist()
        columns[channel.column] = ["" if math.isnan(value) else format(value, channel.csv_format) for value in recorded]
    rows = [",".join(cells) for cells in zip(*columns.values(), strict=True)]
    write_atomically(path, "\n".join([",".join(columns), *rows, ""]))


def read_run_csv(path: Path) -> dict[Channel, tuple[Floats, Floats]]:
    """Time [s] and value [recorded unit] of each channel of a run, (n,) each.

    Raises
    ------
    LceError
        If the file is no such table; names the file, the row and the cell.
    """
    rows = read_csv_rows(path)
    header = [cell.strip() for cell in rows[0]] if rows else []
    unknown = [name for name in header if name not in COLUMNS]
    if unknown or "time_s" not in header or len(set(header)) != len(header):
        raise LceError(f"{path}: header {','.join(header)!r}; expected time_s and of {','.join(COLUMNS[1:])}")
    wide = next((i for i, row in enumerate(rows) if len(row) > len(header)), None)
    if wide is not None:
        raise LceError(
            f"{path}, row {wide + 1}: {len(rows[wide])} cells under a header of {len(header)}; a decimal comma?"
        )
    columns = {name: _column(path, rows, header.index(name), name) for name in header}
    time_s = columns["time_s"]
    if np.isnan(time_s).any():
        raise LceError(f"{path}, row {2 + int(np.argmax(np.isnan(time_s)))}: time_s is empty")
    _check_time(path, time_s)
    present = {channel: columns[channel.column] for channel in CHANNELS if channel.column in columns}
    return {channel: _samples(time_s, values) for channel, values in present.items()}


def _check_time(path: Path, time_s: Floats) -> None:
    back = np.flatnonzero(np.diff(time_s) <= 0.0)
    if back.size:
        i = int(back[0])
        raise LceError(f"{path}, row {i + 3}: time does not increase: {time_s[i + 1]:g} s after {time_s[i]:g} s")


def _column(path: Path, rows: Sequence[Sequence[str]], index: int, name: str) -> Floats:
    """One column (n,), NaN where a cell is empty."""
    values = np.empty(len(rows) - 1)
    for i, row in enumerate(rows[1:]):
        cell = row[index].strip() if index < len(row) else ""
        try:
            values[i] = float(cell) if cell else math.nan
        except ValueError:
            raise LceError(f"{path}, row {i + 2}: {name} is {cell!r}, not a number") from None
        if cell and not math.isfinite(values[i]):
            raise LceError(f"{path}, row {i + 2}: {name} is {cell}")
    return values


def _samples(time_s: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Times and values of the cells that are not empty."""
    there = ~np.isnan(values)
    return time_s[there], values[there]
