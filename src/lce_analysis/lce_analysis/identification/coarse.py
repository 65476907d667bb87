# SPDX-License-Identifier: Apache-2.0
"""Runs on a coarser grid, for searching: several times faster, and what is found is refitted on every sample.

Where the power jumps, the grid stays as fine as it was recorded; in between, its mean over each step is held. In long
recordings the steps are longer where nothing happens, so that a hundred cycles take little more than ten.
"""

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from lce_analysis.prediction import Sampling, SimulationInput
from lce_data.channels import Channel
from lce_data.run import Run, Series

Floats = NDArray[np.float64]

STEP_S: Final = 0.1
"""Longest step of the grid of a search [s]; samples of a sensor lie no closer either."""
FINER_S: Final = 0.05
"""The same between a search and every sample: on it, what depends on 0.1 s finds its place."""
LONG: Final = 60_000
"""A recording of more samples than this, ten minutes at 100 Hz, is long."""
STILL_S: Final = 1.0
"""Longest step [s] of a long recording."""
MOVED: Final = 0.005
"""A step in a long recording ends where a sensor has moved by this share of its range."""
SMOOTH_S: Final = 1.0
"""Time [s] over which a sensor is averaged to see whether it has moved."""
JUMP: Final = 0.02
"""A change of the power by more than this share of its range is a jump."""


def is_long(run_input: SimulationInput) -> bool:
    """Has the recording so many samples that its fits are searched for on the coarser grid, too?"""
    return run_input.time_s.size > LONG


def coarse(run_input: SimulationInput, step_s: float = STEP_S) -> SimulationInput:
    """The run on a coarser grid, with steps of up to ``step_s`` [s]; as it is if that would save little."""
    time, power = run_input.time_s, run_input.power_w
    kept = _sparse_grid(run_input, step_s) if is_long(run_input) else _grid(time, power, step_s)
    if kept.size > 0.7 * time.size:
        return run_input
    held = np.diff(time, append=time[-1])
    energy = np.concatenate([[0.0], np.cumsum(power * held)])
    span = np.diff(time[kept], append=time[-1])
    mean = np.diff(energy[np.append(kept, time.size)])
    run = _thinned(run_input, time[kept], step_s)
    return replace(
        run_input,
        run=run,
        time_s=np.ascontiguousarray(time[kept]),
        power_w=np.ascontiguousarray(np.where(span > 0.0, mean / np.where(span > 0.0, span, 1.0), power[kept])),
        drive_k=np.ascontiguousarray(run_input.drive_k[kept]) if run_input.driven else run_input.drive_k,
        sampling={c: Sampling.between(time[kept], series.time_s) for c, series in run.measured.items()},
    )


def _grid(time_s: Floats, power_w: Floats, step_s: float) -> NDArray[np.intp]:
    """Positions of the samples that stay: one each ``step_s``, and those where the power jumps."""
    number = np.floor((time_s - time_s[0]) / step_s + 1e-6)
    first = np.concatenate([[True], np.diff(number) > 0])
    jumps = np.concatenate([[False], np.abs(np.diff(power_w)) > JUMP * max(float(np.ptp(power_w)), 1e-12)])
    first |= jumps
    first[-1] = True
    return np.flatnonzero(first)


def _sparse_grid(run_input: SimulationInput, step_s: float) -> NDArray[np.intp]:
    """The same for a long recording: fewer where neither sensors nor power have moved."""
    time, power = run_input.time_s, run_input.power_w
    kept = _grid(time, power, step_s)
    there = time[kept]
    moved = np.diff(there, prepend=there[0]) / STILL_S
    for values in (power[kept], *(_averaged(series, there) for series in run_input.run.measured.values())):
        moved += np.abs(np.diff(values, prepend=values[0])) / (MOVED * max(float(np.ptp(values)), 1e-300))
    travelled = np.floor(np.cumsum(moved))
    ends = np.concatenate([[True], np.diff(travelled) > 0.0])
    ends[-1] = True
    return np.asarray(
        kept[ends | np.roll(ends, -1)]
    )  # the sample before a move stays too: the power is held until there


def _averaged(series: Series, time_s: Floats) -> Floats:
    """A sensor's running mean at other times (n,)."""
    width = max(1, round(SMOOTH_S / float(np.median(np.diff(series.time_s)))))
    mean = uniform_filter1d(series.value, width, mode="nearest")
    return np.interp(time_s, series.time_s, mean)


def _thinned(run_input: SimulationInput, grid_s: Floats, step_s: float) -> Run:
    """The run with its sensors' samples no closer than ``step_s``, in a long recording no closer than its grid."""
    run = run_input.run
    thin = partial(_on, grid_s=grid_s) if is_long(run_input) else partial(_every, step_s=step_s)
    series: dict[Channel, Series] = {c: thin(s) for c, s in run.measured.items()}
    return replace(run, series={**run.series, **series})


def _on(series: Series, grid_s: Floats) -> Series:
    """The samples that come next to the times of a grid."""
    kept = np.unique(np.clip(np.searchsorted(series.time_s, grid_s), 0, series.time_s.size - 1))
    return Series(series.time_s[kept], series.value[kept])


def _every(series: Series, step_s: float) -> Series:
    step = float(np.median(np.diff(series.time_s)))
    every = max(1, round(step_s / step))
    return Series(series.time_s[::every], series.value[::every])
