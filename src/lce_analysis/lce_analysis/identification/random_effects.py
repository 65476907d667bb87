# SPDX-License-Identifier: Apache-2.0
"""Parameters that differ from run to run: how much they do, and how well each run knows its own value.

The spread follows from the offsets and their errors, σ² = Σ(offset² + error²)/(runs - 1), both about their mean: a step
of expectation maximisation for the restricted likelihood (Laird and Ware 1982). Where runs are many and each says
little, this draws their values together.
"""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.least_squares import TOLERANCE, Optimum, levenberg_marquardt
from lce_analysis.identification.problem import LOOSE, PARAMETER_STEP, Problem
from lce_analysis.identification.uncertainty import calibrated
from lce_data.progress import Progress
from lce_model import RunValue

Floats = NDArray[np.float64]

ROUNDS: Final = 3
"""Spreads that are tried at most."""
SETTLED: Final = 1.3
"""A spread that changes by less than this factor has settled."""


def settle(
    problem: Problem,
    label: str,
    progress: Progress,
    iterations: int = 100,
    tolerance: float = TOLERANCE,
    slow: float = 0.0,
) -> tuple[Problem, Optimum]:
    """The problem at its least squares, its spreads those that its runs show, and how the search ended.

    ``tolerance`` and ``slow`` end it, as in :func:`levenberg_marquardt`.
    """
    optimum = levenberg_marquardt(problem, problem.first(), label, progress, iterations, tolerance, slow)
    found = problem.at(optimum.variables)
    evaluations = optimum.evaluations
    for _ in range(ROUNDS if found.varying else 0):
        before, found = found.prior_weight, with_spreads(found)
        change = np.abs(np.log(found.prior_weight / before))
        if optimum.interrupted or np.all(change < np.log(SETTLED)):
            break
        optimum = levenberg_marquardt(found, found.first(), label, progress, iterations, tolerance, slow)
        evaluations += optimum.evaluations
        found = found.at(optimum.variables)
    return found, replace(optimum, evaluations=evaluations)


def with_spreads(problem: Problem) -> Problem:
    """The problem, which stands at its least squares, with the spreads that its offsets show."""
    variables, runs = problem.first(), len(problem.inputs)
    k = len(problem.free)
    residual, counted = problem.residuals(variables), sum(series.counted for series in problem.observed)
    covariance = _covariance(problem, variables, max(1.0, float(np.sum(residual**2)) / max(counted, 1.0)))
    centre = np.eye(runs) - 1.0 / runs
    deviations = np.empty(len(problem.varying))
    for v in range(deviations.size):
        mine = slice(k + v * runs, k + (v + 1) * runs)
        offsets, errors = centre @ variables[mine], centre @ covariance[mine, mine]
        deviations[v] = np.sqrt((offsets @ offsets + np.trace(errors)) / max(runs - 1, 1))
    deviations = np.clip(deviations, PARAMETER_STEP, LOOSE)
    varies = dict(problem.model.varies)
    for j, deviation in zip(problem.varying, deviations.tolist(), strict=True):
        key = problem.model.values[problem.free[j]].key
        varies[key] = replace(varies[key], spread=deviation * float(problem.slopes[j]))
    return replace(problem, model=problem.model.varying(varies))


def with_run_errors(problem: Problem) -> Problem:
    """The problem, which stands at its least squares, with the standard error of each run's own values.

    Each series counts by its own residual and correlation, as for all standard errors of a fit.
    """
    variables, runs = problem.first(), len(problem.inputs)
    k = len(problem.free)
    covariance = _covariance(calibrated(problem), variables, 1.0)
    varies = dict(problem.model.varies)
    for v, j in enumerate(problem.varying):
        key = problem.model.values[problem.free[j]].key
        by_run = dict(varies[key].by_run)
        for i, run_input in enumerate(problem.inputs):
            both = [j, k + v * runs + i]
            error = float(np.sqrt(max(covariance[np.ix_(both, both)].sum(), 0.0)) * problem.slopes[j])
            by_run[run_input.run.name] = RunValue(by_run[run_input.run.name].value, error)
        varies[key] = replace(varies[key], by_run=by_run)
    return replace(problem, model=problem.model.varying(varies))


def heterogeneity(problem: Problem, key: str) -> float:
    """Cochran's Q of the values of the runs, χ² of runs - 1 where all are one value but for their errors.

    What all of them share does not count; each series counts by its own residual and correlation.
    """
    variables, runs = problem.first(), len(problem.inputs)
    v = problem.varying.index(problem.free.index(problem.model.index(key)))
    begin = len(problem.free) + v * runs
    mine = slice(begin, begin + runs)
    centre = np.eye(runs) - 1.0 / runs
    covariance = _covariance(calibrated(problem), variables, 1.0)[mine, mine]
    precision = np.linalg.pinv(centre @ covariance @ centre, rcond=1e-9, hermitian=True)
    return float(variables[mine] @ precision @ variables[mine])


def _covariance(problem: Problem, variables: Floats, variance: float) -> Floats:
    """Covariance of the variables if the residuals have this variance; what no sample depends on has none."""
    jacobian, places = problem.jacobian(variables), len(problem.free) + np.arange(problem.offsets)
    information = jacobian.T @ jacobian / variance
    information[places, places] += problem.prior_weight**2
    return np.asarray(np.linalg.pinv(information, rcond=1e-12, hermitian=True))
