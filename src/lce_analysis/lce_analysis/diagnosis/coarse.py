# SPDX-License-Identifier: Apache-2.0
"""Runs on a coarser grid, for searching: several times faster, and what is found is refitted on every sample.

Where the power jumps, the grid stays as fine as it was recorded; in between, its mean over each step is held.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.prediction import Sampling, SimulationInput
from lce_data.channels import Channel
from lce_data.run import Run, Series

Floats = NDArray[np.float64]

STEP_S: Final = 0.05
"""Longest step of the grid [s]; samples of a sensor lie no closer either."""
JUMP: Final = 0.02
"""A change of the power by more than this share of its range is a jump."""


def coarse(run_input: SimulationInput) -> SimulationInput:
    """The run on a coarser grid; as it is if that would save little."""
    time, power = run_input.time_s, run_input.power_w
    kept = _grid(time, power)
    if kept.size > 0.7 * time.size:
        return run_input
    held = np.diff(time, append=time[-1])
    energy = np.concatenate([[0.0], np.cumsum(power * held)])
    span = np.diff(time[kept], append=time[-1])
    mean = np.diff(energy[np.append(kept, time.size)])
    run = _thinned(run_input.run)
    return replace(
        run_input,
        run=run,
        time_s=np.ascontiguousarray(time[kept]),
        power_w=np.ascontiguousarray(np.where(span > 0.0, mean / np.where(span > 0.0, span, 1.0), power[kept])),
        drive_k=np.ascontiguousarray(run_input.drive_k[kept]) if run_input.driven else run_input.drive_k,
        sampling={c: Sampling.between(time[kept], series.time_s) for c, series in run.measured.items()},
    )


def _grid(time_s: Floats, power_w: Floats) -> NDArray[np.intp]:
    """Positions of the samples that stay: one each STEP_S, and those where the power jumps."""
    number = np.floor((time_s - time_s[0]) / STEP_S + 1e-6)
    first = np.concatenate([[True], np.diff(number) > 0])
    jumps = np.concatenate([[False], np.abs(np.diff(power_w)) > JUMP * max(float(np.ptp(power_w)), 1e-12)])
    first |= jumps
    first[-1] = True
    return np.flatnonzero(first)


def _thinned(run: Run) -> Run:
    """The run with its sensors' samples no closer than STEP_S."""
    series: dict[Channel, Series] = {c: _every(s) for c, s in run.measured.items()}
    return replace(run, series={**run.series, **series})


def _every(series: Series) -> Series:
    step = float(np.median(np.diff(series.time_s)))
    every = max(1, round(STEP_S / step))
    return Series(series.time_s[::every], series.value[::every])
