# SPDX-License-Identifier: Apache-2.0
"""Levenberg–Marquardt on a Problem (§4.5, (4.19)), and differential evolution for its first guess (§5.3)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, OptimizeResult, differential_evolution, least_squares

from lce_analysis.identification.problem import Problem
from lce_data.progress import Progress

Floats = NDArray[np.float64]


CROSSOVER: Final = 0.9
DIFFERENTIAL_WEIGHT: Final = 0.8
EPSILON: Final = 1e-4
"""ε1 of §5.3, on the error as (4.18) is printed."""
TOLERANCE: Final = 1e-9
FARTHEST: Final = 1e6
"""Largest weighted residual that counts: a step out of the way shall not overflow."""
POPULATION: Final = 10
"""Candidates per parameter."""
FIRST_CANDIDATES: Final = 4000
SLOW_STEPS: Final = 5
"""Steps by which it is seen that a search hardly gets on."""
SLOW: Final = 3e-4
"""Share of the squared error by which they must lower it, or a search ends whose errors are compared: 5 % is judged."""
GENERATIONS: Final = 20
"""Of a population, at most. It is spread over several minima yet, and least squares find them from its members."""


class _HardlyGetsOn(Exception):
    """Ends a search from within the optimiser."""


@dataclass(frozen=True)
class Optimum:
    """Where an optimiser ended: variables (k,), weighted RMS residual, function evaluations, stopped by the user?"""

    variables: Floats
    rms: float
    evaluations: int
    interrupted: bool


def levenberg_marquardt(
    problem: Problem,
    start: Floats,
    label: str,
    progress: Progress,
    iterations: int = 100,
    tolerance: float = TOLERANCE,
    slow: float = 0.0,
) -> Optimum:
    """MINPACK's Levenberg–Marquardt; a KeyboardInterrupt ends it with the best variables so far.

    It ends where the squared error and the variables change by less than ``tolerance``, relatively, and where
    ``SLOW_STEPS`` steps together lower the squared error by less than its share ``slow``.
    """
    best = Optimum(start, float("inf"), 0, False)
    count = 0
    last: tuple[Floats, Floats] | None = None
    reached: list[float] = []
    # MINPACK may try variables far out of the way; sin makes them valid again, the start temperatures stay physical.
    low, high = np.full(start.size, -np.inf), np.full(start.size, np.inf)
    starts = len(problem.free) + problem.offsets
    low[starts:], high[starts:] = 200.0, 2000.0

    def residuals(variables: Floats) -> Floats:
        nonlocal best, count, last
        count += 1
        clipped = np.clip(variables, low, high)
        r = problem.penalized(clipped)
        last = clipped, r[: problem.size]
        r = np.where(np.isfinite(r), np.clip(r, -FARTHEST, FARTHEST), FARTHEST)
        rms = float(np.sqrt(np.sum(r**2) / problem.size))
        if rms < best.rms:
            best = Optimum(clipped, rms, count, False)
        progress(label, min(count, iterations), iterations, best.rms)
        return r

    def jacobian(variables: Floats) -> Floats:
        reached.append(best.rms**2)
        if len(reached) > SLOW_STEPS and reached[-1 - SLOW_STEPS] - reached[-1] < slow * reached[-1]:
            raise _HardlyGetsOn
        known = last[1] if last is not None and np.array_equal(last[0], variables) else None
        return problem.penalized_jacobian(variables, residuals=known)

    try:
        least_squares(
            residuals,
            start,
            jac=jacobian,
            method="lm",
            x_scale=1.0,
            ftol=tolerance,
            xtol=tolerance,
            gtol=1e-12,
            max_nfev=iterations,
        )
    except _HardlyGetsOn:
        pass
    except KeyboardInterrupt:
        return Optimum(best.variables, best.rms, count, True)
    return Optimum(best.variables, best.rms, count, False)


def evolve(
    problem: Problem,
    enough: float,
    label: str,
    progress: Progress,
    seed: tuple[int, ...],
    box: tuple[Floats, Floats],
) -> tuple[Optimum, Floats]:
    """Differential evolution over the box of the free parameters, until the weighted RMS residual is ``enough``.

    CR = 0.9 and DW = 0.8 as in §5.4; the first population is the best of many random candidates. Returns the best
    candidate, and the last population (m, k) as variables, best first.
    """
    low, high = box
    rng = np.random.default_rng(seed)
    transformation = problem.transformation
    best = Optimum(problem.first()[: low.size], float("inf"), 0, False)
    population = best.variables[None]
    evaluations = done = 0

    def objective(candidates: Floats, /) -> Floats:
        nonlocal evaluations
        evaluations += candidates.shape[1]
        return problem.rms_of_rows(transformation.from_box(candidates.T))

    # scipy passes the result by name to a callback with just this argument.
    def each_generation(intermediate_result: OptimizeResult) -> None:
        nonlocal best, done, population
        done += 1
        order = np.argsort(intermediate_result.population_energies)
        population = transformation.to_search(transformation.from_box(intermediate_result.population[order]))
        best = Optimum(population[0], float(intermediate_result.fun), evaluations, False)
        progress(label, done, GENERATIONS, best.rms)
        if best.rms <= enough:
            raise StopIteration

    try:
        candidates = low + (high - low) * rng.random((FIRST_CANDIDATES, low.size))
        first = candidates[np.argsort(objective(candidates.T))[: POPULATION * low.size]]
        # The stubs know only objectives of one candidate; a vectorised one takes (k, m) and returns (m,).
        differential_evolution(
            objective,  # type: ignore[arg-type]
            Bounds(low, high),
            strategy="best1bin",
            maxiter=GENERATIONS,
            init=first,
            mutation=DIFFERENTIAL_WEIGHT,
            recombination=CROSSOVER,
            tol=1e-3,
            polish=False,
            vectorized=True,
            updating="deferred",
            rng=rng,
            callback=each_generation,
        )
    except KeyboardInterrupt:
        best = Optimum(best.variables, best.rms, evaluations, True)
    return best, population


def scattered(population: Floats, count: int) -> Floats:
    """The first of the population (m, k), and those of its better half that lie farthest from each other."""
    pool = population[: max(count, population.shape[0] // 2)]
    chosen = [0]
    distance = np.linalg.norm(pool - pool[0], axis=1)
    while len(chosen) < min(count, pool.shape[0]):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(pool - pool[chosen[-1]], axis=1))
    return pool[chosen]
