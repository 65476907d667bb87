# SPDX-License-Identifier: Apache-2.0
"""Levenberg–Marquardt on a Problem (§4.5, (4.19)), and differential evolution for its first guess (§5.3)."""

import math
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, OptimizeResult, differential_evolution

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
PHYSICAL_K: Final = (200.0, 2000.0)
"""Start temperatures [K] that are tried."""
FIRST_DAMPING: Final = 1e-6
LEAST_DAMPING: Final = 1e-15
MOST_DAMPING: Final = 1e6
"""Damping μ of (4.19), in units of the largest eigenvalue of JᵀJ: where a search begins, and its ends."""
DAMPED_MORE: Final = 5.0
DAMPED_LESS: Final = 30.0
"""Factors of the damping after a step that did not lower the error, and after one that did at the first trial."""
AHEAD: Final = 0.1
"""Share of a step at which the bend of its way is looked at."""
MOST_BENT: Final = 0.4
"""Longest bend, as a share of its step."""
POPULATION: Final = 10
"""Candidates per parameter."""
FIRST_CANDIDATES: Final = 4000
SLOW_STEPS: Final = 5
"""Steps by which it is seen that a search hardly gets on."""
SLOW: Final = 3e-4
"""Share of the squared error by which they must lower it, or a search ends whose errors are compared: 5 % is judged."""
GENERATIONS: Final = 20
"""Of a population, at most. It is spread over several minima yet, and least squares find them from its members."""


@dataclass(frozen=True)
class Optimum:
    """Where an optimiser ended: variables (k,), weighted RMS residual, function evaluations, stopped by the user?"""

    variables: Floats
    rms: float
    evaluations: int
    interrupted: bool


@dataclass(frozen=True)
class _Point:
    """Variables (k,), the residuals (N + offsets,) there, as they come and none too far, and their squared error."""

    variables: Floats
    computed: Floats
    residual: Floats
    error: float

    @classmethod
    def of(cls, problem: Problem, variables: Floats) -> Self:
        """The start temperatures stay physical; the sine makes any other variables valid."""
        inside, starts = variables.copy(), len(problem.free) + problem.offsets
        inside[starts:] = np.clip(variables[starts:], *PHYSICAL_K)
        computed = problem.penalized(inside)
        residual = np.where(np.isfinite(computed), np.clip(computed, -FARTHEST, FARTHEST), FARTHEST)
        return cls(inside, computed, residual, float(residual @ residual))


@dataclass(frozen=True)
class _Linearized:
    """The residuals near a point by their Jacobian (N + offsets, k), and the eigenvectors of (4.19)."""

    jacobian: Floats
    eigenvalues: Floats
    eigenvectors: Floats

    @classmethod
    def at(cls, problem: Problem, point: _Point) -> Self | None:
        """None where a residual has no slope that is a number."""
        jacobian = problem.penalized_jacobian(point.variables, residuals=point.computed[: problem.size])
        information = jacobian.T @ jacobian
        if not np.all(np.isfinite(information)):
            return None
        eigenvalues, eigenvectors = np.linalg.eigh(information)
        return cls(jacobian, np.clip(eigenvalues, 0.0, None), eigenvectors)

    def step(self, residual: Floats, damping: float) -> Floats:
        """The step (k,) of (4.19) against a residual (N + offsets,)."""
        downhill = -(self.eigenvectors.T @ (self.jacobian.T @ residual))
        return np.asarray(self.eigenvectors @ (downhill / (self.eigenvalues + self._damped(damping))))

    def promise(self, residual: Floats, damping: float) -> float:
        """By how much that step lowers the squared error, if the residuals are linear."""
        downhill, damped = self.eigenvectors.T @ (self.jacobian.T @ residual), self._damped(damping)
        return float(np.sum(downhill**2 * (self.eigenvalues + 2.0 * damped) / (self.eigenvalues + damped) ** 2))

    def _damped(self, damping: float) -> float:
        return max(damping * float(np.max(self.eigenvalues, initial=0.0)), np.finfo(np.float64).tiny)


class _Walk:
    """A search under way, and where it stands."""

    def __init__(self, problem: Problem, start: Floats) -> None:
        self.problem = problem
        self.evaluations = 0
        self.damping = FIRST_DAMPING
        self.here = self._looked_at(start)

    @property
    def rms(self) -> float:
        """Weighted RMS residual."""
        return math.sqrt(self.here.error / self.problem.size)

    def go_on(self, tolerance: float) -> bool:
        """Take a step that lowers the error; False where none does, or none promises to by more than a share."""
        near = _Linearized.at(self.problem, self.here)
        if near is None:
            return False
        negligible, rejected = tolerance * self.here.error, False
        # What is damped promises little: the search has come to its end only where nothing else is left to gain.
        while self.damping > LEAST_DAMPING and near.promise(self.here.residual, self.damping) <= negligible:
            self.damping /= DAMPED_LESS
        while self.damping < MOST_DAMPING and near.promise(self.here.residual, self.damping) > negligible:
            step = near.step(self.here.residual, self.damping)
            there = self._looked_at(self.here.variables + step + self._bend(near, step))
            if there.error < self.here.error:
                if not rejected:
                    self.damping = max(self.damping / DAMPED_LESS, LEAST_DAMPING)
                self.here = there
                return True
            self.damping, rejected = DAMPED_MORE * self.damping, True
        return False

    def _bend(self, near: _Linearized, step: Floats) -> Floats:
        """Half of the acceleration along a step; none where it is too long to be one, as where the strip jumps."""
        ahead = self.problem.penalized(self.here.variables + AHEAD * step)
        self.evaluations += 1
        curvature = 2.0 / AHEAD * ((ahead - self.here.computed) / AHEAD - near.jacobian @ step)
        if not np.all(np.isfinite(curvature)):
            return np.zeros_like(step)
        bend = 0.5 * near.step(curvature, self.damping)
        return bend if np.linalg.norm(bend) <= MOST_BENT * np.linalg.norm(step) else np.zeros_like(step)

    def _looked_at(self, variables: Floats) -> _Point:
        self.evaluations += 1
        return _Point.of(self.problem, variables)


def levenberg_marquardt(
    problem: Problem,
    start: Floats,
    label: str,
    progress: Progress,
    iterations: int = 100,
    tolerance: float = TOLERANCE,
    slow: float = 0.0,
) -> Optimum:
    """Levenberg–Marquardt with geodesic acceleration; a KeyboardInterrupt ends it with the best variables so far.

    A step of (4.19) is straight. Half of its acceleration is added, so that it follows the bend of a narrow valley: the
    answer of the same equations to the second derivative of the residuals along the step (Transtrum and Sethna 2012,
    arXiv:1201.5885).

    It ends after so many ``iterations`` (steps that lower the error), where none promises to lower the squared error by
    more than its share ``tolerance``, and where ``SLOW_STEPS`` together lower it by less than its share ``slow``.
    """
    walk, interrupted = None, False
    try:
        walk = _Walk(problem, start)
        reached = [walk.here.error]
        progress(label, 0, iterations, walk.rms)
        while len(reached) <= iterations and walk.go_on(tolerance):
            reached.append(walk.here.error)
            progress(label, len(reached) - 1, iterations, walk.rms)
            if len(reached) > SLOW_STEPS and reached[-1 - SLOW_STEPS] - reached[-1] < slow * reached[-1]:
                break
    except KeyboardInterrupt:
        interrupted = True
    if walk is None:
        return Optimum(start, math.inf, 0, interrupted)
    return Optimum(walk.here.variables, walk.rms, walk.evaluations, interrupted)


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
