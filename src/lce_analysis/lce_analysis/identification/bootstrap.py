# SPDX-License-Identifier: Apache-2.0
"""Intervals without a linearisation: the fit repeated on data that could have been measured as well.

Each draw is what the fitted model says plus its own residuals, taken in blocks from anywhere in the same series
(moving blocks, Künsch 1989): their correlation stays, their place does not.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.least_squares import levenberg_marquardt
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_analysis.identification.uncertainty import correlation_time
from lce_analysis.options import FitOptions
from lce_data.progress import Progress
from lce_data.units import after_number

Floats = NDArray[np.float64]

ITERATIONS: Final = 30
"""Of each refit, from the optimum of the data as measured: more than any of them takes to converge."""


@dataclass(frozen=True)
class Bootstrap:
    """Free parameters (k,) as fitted, and (draws, k) as fitted again to each draw."""

    keys: tuple[str, ...]
    units: tuple[str, ...]
    best: Floats
    draws: Floats

    def interval(self, level: float = 0.95) -> tuple[Floats, Floats]:
        """Percentiles (k,), (k,) between which a share ``level`` of the draws lies."""
        low, high = np.quantile(self.draws, [0.5 - 0.5 * level, 0.5 + 0.5 * level], axis=0)
        return low, high

    @property
    def sentences(self) -> tuple[str, ...]:
        """The intervals in words, none without a draw."""
        if self.draws.size == 0:
            return ()
        return tuple(
            f"{key} is {best:.4g}{after_number(unit)}, between {low:.4g} and {high:.4g}"
            for key, unit, best, low, high in zip(self.keys, self.units, self.best, *self.interval(), strict=True)
        )


def bootstrap(
    problem: Problem, draws: int, seed: int, progress: Progress, options: FitOptions = FitOptions()
) -> Bootstrap:
    """Refit ``draws`` times a problem that stands at its optimum; a KeyboardInterrupt ends with what is there."""
    values = [problem.model.values[i] for i in problem.free]
    tasks = [partial(_draw, problem, seed, i, draws, options.bootstrap_block) for i in range(draws)]
    found: list[Floats] = []
    with suppress(KeyboardInterrupt):
        found.extend(each(tasks, "bootstrap", progress))
    return Bootstrap(
        keys=tuple(v.key for v in values),
        units=tuple(v.unit for v in values),
        best=np.array([v.value for v in values]),
        draws=np.array(found).reshape(len(found), len(values)),
    )


def _draw(problem: Problem, seed: int, i: int, draws: int, block: float, progress: Progress) -> Floats:
    """Free parameters (k,) of draw ``i``; the same whoever draws it."""
    rng = np.random.default_rng((seed, i))
    first = problem.first()
    residual = problem.residuals(first)
    parts = np.split(residual, np.cumsum([series.size for series in problem.observed])[:-1])
    redrawn = (_redrawn(series, part, rng, block) for series, part in zip(problem.observed, parts, strict=True))
    drawn = replace(problem, observed=tuple(redrawn))
    optimum = levenberg_marquardt(
        drawn, first, "bootstrap", lambda label, done, total, rms: progress(label, i, draws, rms), ITERATIONS, 1e-6
    )
    if optimum.interrupted:
        raise KeyboardInterrupt
    return drawn.split(optimum.variables)[0]


def _redrawn(series: ObservedSeries, residual: Floats, rng: np.random.Generator, block: float) -> ObservedSeries:
    """The series, measured anew; ``residual`` (n,) is weighted, model minus measurement."""
    n = residual.size
    length = min(n, int(np.ceil(block * correlation_time(residual))))
    begins = rng.integers(0, n - length + 1, -(-n // length))
    error = (residual - residual.mean())[(begins[:, None] + np.arange(length)).ravel()[:n]]
    return replace(series, measured=series.measured + (residual - error) / series.weight)
