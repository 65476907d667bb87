# SPDX-License-Identifier: Apache-2.0
"""Where a model jumps its slopes say nothing: the displacements around it are left out of whatever is linearised."""

from dataclasses import replace
from typing import Final

import numpy as np

from lce_analysis.identification.problem import Problem
from lce_analysis.prediction import COLUMN
from lce_data.channels import DISPLACEMENT

DISCONTINUITY: Final = 5.0
"""A step of the modelled displacement so many times larger than all but 1 % of its steps is a discontinuity."""
LEFT_OUT_S: Final = 0.25
"""Samples nearer to a discontinuity than this do not count."""


def without_discontinuities(problem: Problem) -> Problem:
    """The problem without the displacements around a jump of the model.

    Models with a branch for each direction jump where the temperature turns inside the loop. Which side of the jump a
    sample is on is decided within a hundredth of a second, and would outweigh all the rest.
    """
    starts = problem.split(problem.first())[1]
    free = problem.model.vector[list(problem.free)]
    observed = []
    for b in problem.observed:
        if b.channel is DISPLACEMENT:
            time = problem.inputs[b.run].time_s
            out = problem.outputs(b.run, free[None], starts[b.run : b.run + 1])[0]
            moved = np.abs(np.diff(out[:, COLUMN[DISPLACEMENT]]))
            jumps = time[1:][moved > DISCONTINUITY * np.quantile(moved, 0.99) + 1.0 / b.weight]
            at = b.sampling(time)
            near = np.zeros(at.size, dtype=bool)
            for jump in jumps:
                near |= np.abs(at - jump) < LEFT_OUT_S
            b = replace(b, keep=None if not near.any() else np.where(near, 0.0, 1.0))
        observed.append(b)
    return replace(problem, observed=tuple(observed))
