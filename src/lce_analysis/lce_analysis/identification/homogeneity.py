# SPDX-License-Identifier: Apache-2.0
"""Does one value serve all runs? After a fit: what would a value for each run take of the error?

The same promise begins the trials of :mod:`lce_analysis.diagnosis.variation`; here nothing is refitted.
"""

import numpy as np

from lce_analysis.identification.by_run import ByRun
from lce_analysis.identification.problem import Problem
from lce_analysis.options import FitOptions


def differing(problem: Problem, options: FitOptions = FitOptions()) -> tuple[str, ...]:
    """A sentence if a value for each run of some parameter would take much of the squared error; else empty.

    ``problem`` stands at its least squares (:attr:`FitResult.problem`).
    """
    if len(problem.inputs) < 2:
        return ()
    variables = problem.first()
    residual = problem.residuals(variables)
    jacobian = problem.jacobian(variables, residuals=residual)
    total = float(residual @ residual)
    by_run = ByRun(problem, jacobian, residual)
    promises = {key: by_run.gain(key) for key in by_run.keys}
    key = max(promises, key=lambda k: promises[k][0], default="")
    if not key or promises[key][0] < options.differing * total:
        return ()
    gain, changes = promises[key]
    farthest = problem.inputs[int(np.argmax(np.abs(changes - np.median(changes))))].run.name
    return (
        f"one value of {key} does not serve all runs: with a value for each about {gain / total:.0%} of the squared "
        f"error would go; farthest from the others is {farthest}. Fit again with --varies {key}, or ask `lce diagnose` "
        "what differs and what is missing",
    )
