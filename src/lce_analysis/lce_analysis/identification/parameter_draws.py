# SPDX-License-Identifier: Apache-2.0
"""Variables of a fit that the data leave possible: drawn from its covariance, as far as that holds."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.problem import Problem
from lce_analysis.identification.uncertainty import LOOSEST

Floats = NDArray[np.float64]

ALLOWED: Final = 2.0
"""A step of one standard deviation changes the squared predictions by 1, if the model is linear, and by no more than
this."""
HALVINGS: Final = 20
"""A direction along which even so short a step changes too much is left alone."""


def draw_variables(problem: Problem, draws: int, seed: int) -> Floats:
    """Variables (draws, all) from the covariance of a problem that stands at its optimum.

    The residuals of the problem count as independent ones of variance 1. Shared parameters, offsets of runs and start
    temperatures are drawn together, with their correlations.

    The covariance is that of the linearised model. Along a direction that the data hardly determine, and where a
    parameter is at a bound, the linearisation ends before one standard deviation does: there the step is halved until
    it changes the predictions by no more than the step of a linear model would.
    """
    first = problem.first()
    if not first.size:
        return np.empty((draws, 0))
    _, singular, rows = np.linalg.svd(problem.penalized_jacobian(first, central=True), full_matrices=False)
    steps = rows / np.maximum(singular, 1.0 / LOOSEST)[:, None]
    here = problem.penalized(first)
    for step in steps:
        _shorten(step, problem, first, here)
    return np.asarray(first + np.random.default_rng(seed).standard_normal((draws, len(steps))) @ steps)


def _shorten(step: Floats, problem: Problem, first: Floats, here: Floats) -> None:
    """Halve a step (variables,) in place until it changes the predictions by no more than is allowed."""
    for _ in range(HALVINGS):
        changes = [problem.penalized(first + sign * step) - here for sign in (1.0, -1.0)]
        if all(float(change @ change) <= ALLOWED for change in changes):
            return
        step *= 0.5
    step[:] = 0.0
