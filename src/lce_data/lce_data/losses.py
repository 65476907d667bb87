# SPDX-License-Identifier: Apache-2.0
"""Samples that a recorder has counted as lost, and what they leave unknown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import POWER, SENSORS, Channel
from lce_data.run import Run, Series

Floats = NDArray[np.float64]

GAP_STEPS = 1.5
"""An interval between two samples is a gap from so many median intervals on."""


def lost_samples(run: Run) -> str:
    """A sentence on the samples that were lost, by topic, and between which times; empty if there are none."""
    told = []
    for channel, series in run.series.items():
        lost = _lost(run, channel)
        begin_s, end_s = _gaps(series)
        if lost:
            when = f" between {begin_s[0]:.6g} and {end_s[-1]:.6g} s" if begin_s.size else ""
            told.append(f"{lost} of {lost + series.time_s.size} {channel.topic} samples lost{when}")
    if not told:
        return ""
    held = "; measurements while the power is not known were left out" if _lost(run, POWER) else ""
    return f"{', '.join(told)}{held}"


def without_unknown_power(run: Run) -> Run:
    """The run without the measurements that fall into a time of which the samples of the laser power were lost.

    The power counts as held from sample to sample. Where samples are lost it may have been another one.
    """
    if run.power is None or not _lost(run, POWER):
        return run
    gaps = _gaps(run.power)
    left = {c: _outside(series, *gaps) if c in SENSORS else series for c, series in run.series.items()}
    return replace(run, series={c: series for c, series in left.items() if series.time_s.size})


def _lost(run: Run, channel: Channel) -> int:
    """Samples that the recorder has counted as lost on the topic that was read, in whatever namespace."""
    counts = run.experiment.lost or {}
    for topic in filter(None, (channel.stamped_topic, channel.topic)):
        found = [count for name, count in counts.items() if f"/{name}".endswith(f"/{topic}")]
        if found:
            return sum(found)
    return 0


def _gaps(series: Series) -> tuple[Floats, Floats]:
    """Begin and end [s] of the gaps of a series, (n,) each: where a sample was due, and the next one that came."""
    steps = np.diff(series.time_s)
    step_s = float(np.median(steps)) if steps.size else 0.0
    before = np.flatnonzero(steps > GAP_STEPS * step_s)
    return series.time_s[before] + step_s, series.time_s[before + 1]


def _outside(series: Series, begin_s: Floats, end_s: Floats) -> Series:
    """The samples that lie in none of the intervals [begin, end)."""
    kept = np.searchsorted(begin_s, series.time_s, "right") == np.searchsorted(end_s, series.time_s, "right")
    return Series(series.time_s[kept], series.value[kept])
