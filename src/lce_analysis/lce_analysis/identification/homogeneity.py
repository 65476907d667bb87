# SPDX-License-Identifier: Apache-2.0
"""Does one value serve all runs? After a fit: what would a value for each run take of the error?

The same promise begins the trials of :mod:`lce_analysis.diagnosis.variation`; here nothing is refitted.
"""

from lce_analysis.identification.problem import Problem
from lce_analysis.identification.random_effects import gain_by_run, may_vary
from lce_analysis.options import FitOptions


def differing(problem: Problem, options: FitOptions = FitOptions()) -> tuple[str, ...]:
    """A sentence if a value for each run of some parameter would take much of the squared error; else empty.

    ``problem`` stands at its least squares (:attr:`FitResult.problem`).
    """
    if len(problem.inputs) < 2:
        return ()
    variables = problem.first()
    jacobian, residual = problem.jacobian(variables), problem.residuals(variables)
    total = float(residual @ residual)
    gains = {key: gain_by_run(problem, jacobian, residual, key) for key in may_vary(problem)}
    key = max(gains, key=lambda k: gains[k], default="")
    if not key or gains[key] < options.differing * total:
        return ()
    return (
        f"one value of {key} does not serve all runs: with a value for each about {gains[key] / total:.0%} of the "
        f"squared error would go. Fit again with --varies {key}, or ask `lce diagnose` what differs",
    )
