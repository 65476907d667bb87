# SPDX-License-Identifier: Apache-2.0
"""Where a model jumps its slopes say nothing: the samples around a jump are left out of whatever is linearised."""

from dataclasses import replace
from typing import Final

import numpy as np

from lce_analysis.identification.problem import Problem
from lce_analysis.prediction import COLUMN, MECHANICAL

# Both are numbers of the linearisation, not choices: the model itself is compared with every sample.
DISCONTINUITY: Final = 5.0
"""A step of a modelled series that is this many times larger than all but 1 % of its steps is a discontinuity."""
LEFT_OUT_S: Final = 0.25
"""Samples nearer to a discontinuity than this [s] do not count."""


def without_discontinuities(problem: Problem) -> Problem:
    """The problem without the samples around a jump of the model, in each series from behind the temperature.

    Models with a branch for each direction jump where the temperature turns inside the loop. Which side of the jump a
    sample is on is decided within a hundredth of a second, and would outweigh all the rest.
    """
    starts = problem.split(problem.first())[1]
    free = problem.model.vector[list(problem.free)]
    observed = []
    for series in problem.observed:
        if series.channel in MECHANICAL:
            time = problem.inputs[series.run].time_s
            out = problem.outputs(series.run, free[None], starts[series.run : series.run + 1])[0]
            moved = np.abs(np.diff(out[:, COLUMN[series.channel]]))
            jumps = time[1:][moved > DISCONTINUITY * np.quantile(moved, 0.99) + 1.0 / series.weight]
            at = series.sampling(time)
            near = np.zeros(at.size, dtype=bool)
            for jump in jumps:
                near |= np.abs(at - jump) < LEFT_OUT_S
            series = replace(series, keep=None if not near.any() else np.where(near, 0.0, 1.0))
        observed.append(series)
    return replace(problem, observed=tuple(observed))
