# SPDX-License-Identifier: Apache-2.0
"""Samples in intervals, and means over them."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from lce_data.errors import LceError
from lce_data.run import Series

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Interval = tuple[float, float]


def within(time_s: Floats, intervals: Collection[Interval]) -> Flags:
    """Which times (n,) lie in one of the intervals, ends included."""
    here = np.zeros(time_s.size, dtype=np.bool_)
    for begin, end in intervals:
        here |= (time_s >= begin) & (time_s <= end)
    return here


def at(series: Series, here: Flags) -> Series:
    """Some samples of a series."""
    return Series(series.time_s[here], series.value[here])


def median_step(series: Series) -> float:
    """Median time from sample to sample [s]; infinite for one sample."""
    return float(np.median(np.diff(series.time_s))) if series.time_s.size > 1 else math.inf


def means(series: Series, dt_s: float) -> Series:
    """Means of times and values in the intervals [k dt, (k + 1) dt)."""
    number = np.floor(series.time_s / dt_s + 1e-6)
    begins = np.flatnonzero(np.diff(number, prepend=number[0] - 1.0))
    count = np.diff(begins, append=number.size)
    return Series(np.add.reduceat(series.time_s, begins) / count, np.add.reduceat(series.value, begins) / count)


def held_means(series: Series, dt_s: float, end_s: float) -> Series:
    """Means of a held signal over intervals of dt from its first sample to ``end_s``, not before its last one.

    Their energy is the same; the last value is held on from ``end_s``.
    """
    time_s = series.time_s
    edges = np.append(np.arange(time_s[0], end_s - 1e-6 * dt_s, dt_s), end_s)
    energy = np.concatenate([[0.0], np.cumsum(np.diff(np.append(time_s, end_s)) * series.value)])
    until = np.interp(edges, np.append(time_s, end_s), energy)
    return Series(edges, np.append(np.diff(until) / np.diff(edges), series.value[-1]))


def behind(first: Series, second: Series, name: str) -> Series:
    """Two series of one channel, one after the other. Raises LceError with its name if they overlap."""
    if second.time_s[-1] < first.time_s[0]:
        first, second = second, first
    if second.time_s[0] <= first.time_s[-1]:
        raise LceError(
            f"both have {name} between {max(first.time_s[0], second.time_s[0]):g} and "
            f"{min(first.time_s[-1], second.time_s[-1]):g} s; cut one, or begin it elsewhere"
        )
    return Series(np.append(first.time_s, second.time_s), np.append(first.value, second.value))
