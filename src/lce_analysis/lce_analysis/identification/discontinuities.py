# SPDX-License-Identifier: Apache-2.0
"""Where a model jumps its slopes say nothing: the samples around a jump are left out of whatever is linearised."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.problem import Problem
from lce_analysis.prediction import COLUMN, MECHANICAL

Floats = NDArray[np.float64]

# All are numbers of the linearisation, not choices: the model itself is compared with every sample.
DISCONTINUITY: Final = 5.0
"""A step of a modelled series that is this many times larger than all but 1 % of its steps may be a discontinuity."""
ALONE: Final = 3.0
"""It is one if it is this many times larger than the steps beside it: a fast motion takes several steps."""
LEFT_OUT_S: Final = 0.25
"""Samples nearer to a discontinuity than this [s] do not count."""


def discontinuities(time_s: Floats, modelled: Floats, noise: float) -> Floats:
    """Times [s] at which a modelled series (n,) jumps by more than its sensor's noise."""
    moved = np.abs(np.diff(modelled))
    beside = np.maximum(np.concatenate([[0.0], moved[:-1]]), np.concatenate([moved[1:], [0.0]]))
    large = moved > DISCONTINUITY * np.quantile(moved, 0.99) + noise
    return np.asarray(time_s[1:][large & (moved > ALONE * beside)])


def away_from(jumps_s: Floats, time_s: Floats) -> NDArray[np.bool_]:
    """Which samples (n,) lie away from all jumps."""
    near = np.zeros(time_s.size, dtype=bool)
    for jump in jumps_s:
        near |= np.abs(time_s - jump) < LEFT_OUT_S
    return ~near


def without_discontinuities(problem: Problem) -> Problem:
    """The problem without the samples around a jump of the model, in each series from behind the temperature.

    Models with a branch for each direction jump where the temperature turns inside the loop. Which side of the jump a
    sample is on is decided within a hundredth of a second, and would outweigh all the rest.
    """
    observed = []
    for series in problem.observed:
        if series.channel in MECHANICAL:
            time = problem.inputs[series.run].time_s
            modelled = problem.simulated(series.run)[:, COLUMN[series.channel]]
            jumps = discontinuities(time, modelled, 1.0 / series.weight)
            counted = away_from(jumps, series.sampling(time))
            series = replace(series, keep=None if counted.all() else counted.astype(np.float64))
        observed.append(series)
    return replace(problem, observed=tuple(observed))
