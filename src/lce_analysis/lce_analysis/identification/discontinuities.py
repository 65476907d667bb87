# SPDX-License-Identifier: Apache-2.0
"""Where a model jumps its slopes say nothing: the samples around a jump are left out of whatever is linearised."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from lce_analysis.identification.problem import Problem
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.prediction import COLUMN, MECHANICAL, Sampling, SimulationInput

UNRESOLVED: Final = 0.5
"""A sample that a coarser grid gets wrong by more than this share of its sensor's noise does not count on it."""
EITHER_SIDE: Final = 3.0
"""Around a jump an error counts as at most so many times the noise: which side a sample is on says no more."""


def without_discontinuities(problem: Problem, recorded: Sequence[SimulationInput] = ()) -> Problem:
    """The problem without the samples around a jump of the model, in each series from behind the temperature.

    Models with a branch for each direction jump where the temperature turns inside the loop. Which side of the jump a
    sample is on is decided within a hundredth of a second, and would outweigh all the rest.

    recorded : of a problem on a coarser grid, the runs as they were recorded. The jumps are those on these, and samples
        of a motion that the coarser grid does not resolve are left out, too.
    """
    fine = replace(problem, inputs=recorded) if recorded else problem
    observed = []
    for series in problem.observed:
        if series.channel in MECHANICAL:
            column, time = COLUMN[series.channel], problem.inputs[series.run].time_s
            fine_time, fine_modelled = fine.inputs[series.run].time_s, fine.simulated(series.run)[:, column]
            jumps = discontinuities(fine_time, fine_modelled, 1.0 / series.weight)
            counted = away_from(jumps, series.sampling(time))
            if recorded:
                there = Sampling.between(fine_time, series.sampling(time))(fine_modelled)
                wrong = np.abs(series.sampling(problem.simulated(series.run)[:, column]) - there)
                counted &= wrong * series.weight <= UNRESOLVED
            if not counted.all():
                keep = counted.astype(np.float64)
                series = replace(series, keep=keep if series.keep is None else keep * series.keep)
        observed.append(series)
    return replace(problem, observed=tuple(observed))


def squared_error(problem: Problem, recorded: Sequence[SimulationInput] = ()) -> float:
    """Squared error in units of the noise, each sample around a jump of the model with a bounded one.

    So a sample on the wrong side of a jump counts for little, and a jump at the wrong time for as much as it lasts.

    recorded : as of :func:`without_discontinuities`.
    """
    squared = problem.residuals(problem.first()) ** 2
    away = without_discontinuities(problem, recorded).observed
    counted = np.concatenate([np.ones(s.size) if s.keep is None else s.keep[s.whitening.size - 1 :] for s in away])
    return float(np.sum(np.where(counted > 0.0, squared, np.minimum(squared, EITHER_SIDE**2))))
