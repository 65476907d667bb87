# SPDX-License-Identifier: Apache-2.0
"""Read `wave.csv`: columns `time_s,power_w`, time strictly increasing, power finite and not negative."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lce_data.errors import LceError

MAX_DURATION_S = 86400.0
"""Longest waveform that is accepted, one day."""

COLUMNS = ("time_s", "power_w")


def read_wave(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time [s] (n,) and power [W] (n,) of a CSV file; other columns are ignored.

    Raises LceError naming the file, the line and the value.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except OSError as error:
        raise LceError(f"{path}: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise LceError(f"{path}: not a CSV text file") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        raise LceError(f"{path}: no column {', '.join(missing)}; a wave needs the header {','.join(COLUMNS)}")
    at = [header.index(name) for name in COLUMNS]
    values = [_row(path, line, row, at) for line, row in enumerate(rows[1:], start=2) if any(row)]
    if not values:
        raise LceError(f"{path}: no rows below the header")
    time_s, power_w = np.array(values).T.copy()
    _check(path, time_s, power_w)
    return time_s, power_w


def _row(path: Path, line: int, row: list[str], at: list[int]) -> tuple[float, float]:
    cells = [row[k].strip() if k < len(row) else "" for k in at]
    try:
        time_s, power_w = (float(cell) for cell in cells)
    except ValueError:
        raise LceError(f"{path}, line {line}: {','.join(cells)!r} is not two numbers") from None
    if not (math.isfinite(time_s) and math.isfinite(power_w)):
        raise LceError(f"{path}, line {line}: {','.join(cells)!r} is not finite")
    if power_w < 0:
        raise LceError(f"{path}, line {line}: power_w = {power_w:g} W; a laser gives 0 W or more")
    return time_s, power_w


def _check(path: Path, time_s: NDArray[np.float64], power_w: NDArray[np.float64]) -> None:
    back = np.flatnonzero(np.diff(time_s) <= 0)
    if back.size:
        k = int(back[0])
        raise LceError(f"{path}: time does not increase: {time_s[k + 1]:g} s after {time_s[k]:g} s (row {k + 2})")
    if time_s[0] < 0:
        raise LceError(f"{path}: time starts at {time_s[0]:g} s; it must not be negative")
    if time_s[-1] > MAX_DURATION_S:
        raise LceError(f"{path}: {time_s[-1]:g} s is longer than {MAX_DURATION_S:g} s")
