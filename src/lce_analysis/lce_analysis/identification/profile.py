# SPDX-License-Identifier: Apache-2.0
"""Profile likelihoods: each parameter held at values around its optimum, all others fitted anew.

Where the misfit rises past the threshold on both sides the parameter has an interval; where it stays flat up to the
bounds of the search the data do not determine it, whatever a linearised standard error says.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from lce_analysis.identification.least_squares import levenberg_marquardt
from lce_analysis.identification.parallel import each
from lce_analysis.identification.problem import Problem
from lce_analysis.identification.uncertainty import calibrated
from lce_analysis.options import FitOptions
from lce_data.progress import Progress

Floats = NDArray[np.float64]

ITERATIONS: Final = 12
"""Of the least squares at each value, from its neighbour's optimum: more than any of them takes to converge."""


@dataclass(frozen=True)
class Profile:
    """The rise of the misfit over one parameter.

    values : (n,) of the parameter, rising. rise : (n,) of χ² above its least value, others fitted.
    low, high : ends of the interval at the level, None if it is open within the bounds of the search.
    """

    key: str
    unit: str
    best: float
    values: Floats
    rise: Floats
    low: float | None
    high: float | None

    @property
    def sentence(self) -> str:
        """What the data say of the parameter."""
        unit = f" {self.unit}" if self.unit != "1" else ""
        if self.low is None and self.high is None:
            return f"{self.key} is not determined"
        if self.low is None:
            return f"{self.key} is at most {self.high:.4g}{unit}"
        if self.high is None:
            return f"{self.key} is at least {self.low:.4g}{unit}"
        return f"{self.key} is {self.best:.4g}{unit}, between {self.low:.4g} and {self.high:.4g}"


def profiles(
    problem: Problem, progress: Progress, level: float = 0.95, options: FitOptions = FitOptions()
) -> tuple[Profile, ...]:
    """One for each free parameter of a problem that stands at its optimum; a KeyboardInterrupt ends early.

    χ² counts residuals as independent ones (:func:`lce_analysis.identification.uncertainty.calibrated`).
    """
    counted = calibrated(problem)
    threshold = float(chi2.ppf(level, 1))
    found: list[Profile] = []
    with suppress(KeyboardInterrupt):
        tasks = [partial(_profile, counted, j, threshold, options.profile_points) for j in range(len(counted.free))]
        found.extend(each(tasks, "profiles", progress))
    return tuple(found)


def _profile(problem: Problem, j: int, threshold: float, most: int, progress: Progress) -> Profile:
    value = problem.model.values[problem.free[j]]
    least = problem.penalized(problem.first())
    sides, ends = [], []
    for sign in (-1.0, 1.0):
        points = [(value.value, 0.0)]
        for point in _walk(problem, j, sign, threshold, float(least @ least), most, progress):
            points.append(point)
            if point[1] > threshold:
                break
        sides.append(points)
        ends.append(_crossing(points, threshold))
    values, rise = np.array([*sides[0][:0:-1], *sides[1]]).T
    return Profile(value.key, value.unit, value.value, values, rise, ends[0], ends[1])


def _walk(
    problem: Problem, j: int, sign: float, threshold: float, least: float, most: int, progress: Progress
) -> Iterator[tuple[float, float]]:
    """(value, rise of χ²) further and further from the optimum, at ``most`` so many, up to the bound."""
    c = problem.transformation
    key = problem.model.values[problem.free[j]].key
    here = c.to_box(problem.model.vector[list(problem.free)])
    step = _first_step(problem, j)
    others = replace(problem, free=tuple(i for i in problem.free if i != problem.free[j]))
    variables = others.first()
    for n in range(1, most + 1):
        box = here.copy()
        box[j] = np.clip(here[j] + sign * step, 0.0, 1.0)
        at = float(c.from_box(box)[j])
        held = replace(others, model=problem.model.set({key: at}))
        optimum = levenberg_marquardt(
            held, variables, f"profile of {key}", _as_part(progress, n, most), ITERATIONS, 1e-5
        )
        if optimum.interrupted:
            raise KeyboardInterrupt
        variables = optimum.variables
        rise = max(optimum.rms**2 * held.size - least, 0.0)
        yield at, rise
        if box[j] in (0.0, 1.0):
            return
        # A parabola's guess of where the threshold is, no more than twice and no less than half as far again.
        step *= float(np.clip(1.05 * np.sqrt(threshold / max(rise, 1e-3)), 1.3, 2.0))


def _first_step(problem: Problem, j: int) -> float:
    """The parameter's standard error in its box, all others open; a tenth of the box at most."""
    jacobian = problem.jacobian(problem.first(), central=True)
    rest, own = np.delete(jacobian, j, axis=1), jacobian[:, j]
    own = own - rest @ np.linalg.lstsq(rest, own, rcond=1e-9)[0]
    u = problem.transformation.to_box(problem.model.vector[list(problem.free)])[j]
    slope = np.sqrt(max(u * (1.0 - u), 1e-8))  # du/dz of u = (sin z + 1)/2
    return float(np.clip(slope / max(np.linalg.norm(own), 1e-300), 1e-5, 0.1))


def _as_part(progress: Progress, n: int, most: int) -> Progress:
    """The bar shows how many of the points on a side are done."""
    return lambda label, done, total, rms: progress(label, n - 1, most, rms)


def _crossing(points: list[tuple[float, float]], threshold: float) -> float | None:
    """Where the rise passes the threshold, by interpolating its root; None if it does not."""
    (near, below), (far, above) = points[-2:]
    if above <= threshold:
        return None
    low, high = np.sqrt(below), np.sqrt(above)
    return float(near + (far - near) * (np.sqrt(threshold) - low) / (high - low))
