# SPDX-License-Identifier: Apache-2.0
"""Where a model jumps its slopes say nothing: the samples around a jump are left out of whatever is linearised."""

from dataclasses import replace

import numpy as np

from lce_analysis.identification.problem import Problem
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.prediction import COLUMN, MECHANICAL


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
            counted = away_from(jumps, series.sampling(time)).astype(np.float64)
            if counted.min() == 0.0:
                series = replace(series, keep=counted if series.keep is None else counted * series.keep)
        observed.append(series)
    return replace(problem, observed=tuple(observed))
