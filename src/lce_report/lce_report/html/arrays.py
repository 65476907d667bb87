# SPDX-License-Identifier: Apache-2.0
"""The numbers of a page: thinned to what the eye can see and packed (Arrays), or as they are (Samples)."""

import base64
import zlib
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

BUCKETS: Final = 4000
"""More than the pixels across any screen."""
WIDE, HIGH = 1200, 800
"""Cells across a plane of points; what falls into one cell is one point to the eye."""
LEVELS: Final = 65534
GAP: Final = 65535


class Arrays:
    """All numbers of a page as one deflated block of 16-bit differences.

    An array is quantised to 65534 steps of its own range, a hundred times finer than a screen, and stored as the
    differences from number to number, which smooth curves deflate to little. The page gets [begin, length, low, step]
    and adds up; GAP stands for NaN.
    """

    def __init__(self) -> None:
        self._parts: list[NDArray[np.uint16]] = []
        self._length = 0
        self._known: dict[bytes, tuple[int, int, float, float]] = {}

    def add(self, values: Floats) -> tuple[int, int, float, float]:
        """Keep an array (n,) and return where it is; the same array again costs nothing."""
        values = np.ascontiguousarray(values, dtype=np.float64)
        key = values.tobytes()
        if key not in self._known:
            there = np.isfinite(values)
            low, high = (float(values[there].min()), float(values[there].max())) if there.any() else (0.0, 0.0)
            step = (high - low) / LEVELS or 1.0
            codes = np.where(there, np.rint((np.where(there, values, low) - low) / step), GAP).astype(np.uint16)
            self._parts.append(np.diff(codes, prepend=np.uint16(0)))
            self._known[key] = (self._length, values.size, low, step)
            self._length += values.size
        return self._known[key]

    def packed(self) -> str:
        """The block in base64."""
        raw = np.concatenate(self._parts).astype("<u2").tobytes() if self._parts else b""
        return base64.b64encode(zlib.compress(raw, 9)).decode("ascii")


class Samples:
    """All numbers of a page in single precision, none left out: for the workbench, whose page is near its server.

    The page gets [begin, length]; NaN is a gap.
    """

    def __init__(self) -> None:
        self._parts: list[NDArray[np.float32]] = []
        self._length = 0

    def add(self, values: Floats) -> tuple[int, int]:
        """Keep an array (n,) and return where it is."""
        self._parts.append(values.astype("<f4"))
        self._length += values.size
        return self._length - values.size, values.size

    def packed(self) -> bytes:
        """The numbers, little-endian."""
        return b"".join(part.tobytes() for part in self._parts)


def visible(series: Sequence[Floats]) -> Indices:
    """Indices (m,) that draw all series (n,) like the full ones: the extremes of each in every bucket, and the ends."""
    n = series[0].size
    if n <= 4 * BUCKETS:
        return np.arange(n)
    length = -(-n // BUCKETS)
    begin = np.arange(0, n, length)
    keep = [np.array([0, n - 1])]
    for values in series:
        buckets = np.pad(values, (0, begin.size * length - n), mode="edge").reshape(-1, length)
        lowest, highest = (np.nan_to_num(side, nan=np.inf).argmin(axis=1) for side in (buckets, -buckets))
        keep += [np.minimum(begin + lowest, n - 1), np.minimum(begin + highest, n - 1)]
    return np.unique(np.concatenate(keep))


def distinct(x: Floats, y: Floats, joined: bool) -> Indices:
    """Indices of the points (n,) that the eye can tell apart in a plane; of a joined line, where it moves on."""
    cell = _steps(x, WIDE) * (HIGH + 1) + _steps(y, HIGH)
    if joined:
        return np.flatnonzero(np.diff(cell, prepend=-1) != 0)
    return np.sort(np.unique(cell, return_index=True)[1])


def _steps(values: Floats, count: int) -> Indices:
    there = values[np.isfinite(values)]
    low, high = (float(there.min()), float(there.max())) if there.size else (0.0, 0.0)
    return np.nan_to_num((values - low) / ((high - low) or 1.0) * count).astype(np.intp)
