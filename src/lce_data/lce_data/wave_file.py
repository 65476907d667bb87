# SPDX-License-Identifier: Apache-2.0
"""A waveform as a CSV file: `time_s,power_w`, time strictly increasing, power finite and not negative."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.errors import LceError
from lce_data.files import read_csv_rows, write_atomically

Floats = NDArray[np.float64]

MAX_DURATION_S: Final = 86400.0
"""Longest waveform that is accepted, one day."""

COLUMNS: Final = ("time_s", "power_w")

_FINEST_S: Final = 0.01
"""Time step of waveforms at the rate of the bench, 100 Hz: two decimals hold it."""


def write_wave(path: Path, time_s: Floats, power_w: Floats) -> None:
    """Write a waveform, time [s] (n,) and power [W] (n,).

    Raises
    ------
    LceError
        If `read_wave` would refuse it, or the file cannot be written.
    """
    if not (np.isfinite(time_s).all() and np.isfinite(power_w).all()):
        raise LceError(f"{path}: the waveform is not finite")
    if power_w.min() < 0:
        raise LceError(f"{path}: power_w = {power_w.min():g} W; a laser gives 0 W or more")
    _check_time(path, time_s)
    ticks = time_s / _FINEST_S
    decimals = 2 if np.allclose(ticks, np.round(ticks), rtol=0.0, atol=1e-4) else 9
    rows = [f"{t:.{decimals}f},{p:.6g}" for t, p in zip(time_s, power_w, strict=True)]
    write_atomically(path, "\n".join([",".join(COLUMNS), *rows, ""]))


def read_wave(path: Path) -> tuple[Floats, Floats]:
    """Time [s] (n,) and power [W] (n,) of a CSV file; other columns are ignored.

    Raises LceError naming the file, the line and the value.
    """
    rows = read_csv_rows(path)
    header = [cell.strip() for cell in rows[0]] if rows else []
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        raise LceError(f"{path}: no column {', '.join(missing)}; a wave needs the header {','.join(COLUMNS)}")
    at = [header.index(name) for name in COLUMNS]
    values = [_row(path, line, row, at) for line, row in enumerate(rows[1:], start=2) if any(row)]
    if not values:
        raise LceError(f"{path}: no rows below the header")
    time_s, power_w = np.array(values).T.copy()
    _check_time(path, time_s)
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


def _check_time(path: Path, time_s: Floats) -> None:
    back = np.flatnonzero(np.diff(time_s) <= 0)
    if back.size:
        k = int(back[0])
        raise LceError(f"{path}: time does not increase: {time_s[k + 1]:g} s after {time_s[k]:g} s (row {k + 2})")
    if time_s[0] < 0:
        raise LceError(f"{path}: time starts at {time_s[0]:g} s; it must not be negative")
    if time_s[-1] > MAX_DURATION_S:
        raise LceError(f"{path}: {time_s[-1]:g} s is longer than {MAX_DURATION_S:g} s")
