# SPDX-License-Identifier: Apache-2.0
"""Levenberg–Marquardt of MINPACK beside that of the bench: the same problems from the same starts.

Strips of the hidden cases, from where an identification in stages ends: all parameters of both stages at once, then the
same with an effect that the strip does not have.
"""

import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from campaign import campaign
from diagnosis import SIX_RUNS
from families import FAMILIES
from scipy.optimize import least_squares
from tqdm import tqdm

from lce_analysis.identification.coarse import coarse
from lce_analysis.identification.identify import rough_fit
from lce_analysis.identification.least_squares import FARTHEST, SLOW, SLOW_STEPS, levenberg_marquardt
from lce_analysis.identification.problem import Floats, Problem, observed_series, start_conditions
from lce_analysis.options import FitOptions
from lce_analysis.prediction import simulation_input
from lce_data.channels import SENSORS
from lce_data.noise import sensor_noise
from lce_data.progress import silent
from lce_data.run import Run
from lce_model import Model, default_model
from lce_model.effects import find

TRIED = ("emissivity_error", "latent_heat")
"""Effects that none of the strips has."""
TOLERANCE = 1e-6
MOST = 400
"""Trials, with either; more than any needs here."""


@dataclass(frozen=True)
class Search:
    """How a search went: Jacobians, seconds, squared error at its end."""

    jacobians: int
    seconds: float
    error: float


class _Counting(Problem):
    """A problem that knows how often its Jacobian was asked for."""

    asked = 0

    def penalized_jacobian(self, *args: Any, **options: Any) -> Floats:
        """As of the problem."""
        _Counting.asked += 1
        return super().penalized_jacobian(*args, **options)


def minpack(problem: Problem) -> Search:
    """SciPy's, ended by the same rules."""
    reached: list[float] = []
    best = np.inf

    class HardlyGetsOn(Exception):
        pass

    def residuals(variables: Floats) -> Floats:
        nonlocal best
        residual = np.clip(problem.penalized(variables), -FARTHEST, FARTHEST)
        best = min(best, float(residual @ residual))
        return residual

    def jacobian(variables: Floats) -> Floats:
        reached.append(best)
        if len(reached) > SLOW_STEPS and reached[-1 - SLOW_STEPS] - reached[-1] < SLOW * reached[-1]:
            raise HardlyGetsOn
        return problem.penalized_jacobian(variables)

    began = time.perf_counter()
    with suppress(HardlyGetsOn):
        least_squares(
            residuals,
            problem.first(),
            jacobian,
            method="lm",
            x_scale=1.0,
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=1e-12,
            max_nfev=MOST,
        )
    return Search(len(reached), time.perf_counter() - began, best)


def accelerated(problem: Problem) -> Search:
    """That of the bench."""
    counting = _Counting(**{name: getattr(problem, name) for name in Problem.__dataclass_fields__})
    _Counting.asked = 0
    began = time.perf_counter()
    found = levenberg_marquardt(counting, problem.first(), "", silent, MOST, TOLERANCE, SLOW)
    return Search(_Counting.asked, time.perf_counter() - began, found.rms**2 * problem.size)


def problems(model: Model, runs: Sequence[Run]) -> list[Problem]:
    """The base model beside the runs, and with each effect that is tried."""
    begun = rough_fit(model, runs, FitOptions(), silent)
    found = []
    for tried in (begun, *(begun.add(find(name)) for name in TRIED)):
        inputs = [coarse(simulation_input(run, tried)) for run in runs]
        free = tuple(i for i, v in enumerate(tried.values) if tried.searches(v))
        observed = observed_series(inputs, sensor_noise([one.run for one in inputs], SENSORS))
        starts = np.array([one.start_k for one in inputs])
        found.append(Problem(tried, inputs, free, starts, observed, *start_conditions(inputs, tried)))
    return found


def measure() -> list[str]:
    """The table, as lines of Markdown."""
    rows = []
    for case in tqdm(SIX_RUNS, unit="strip", dynamic_ncols=True):
        train, _ = campaign(case)
        pairs = []
        for problem in problems(default_model("lumped", FAMILIES[case.family].base), train):
            problem.penalized_jacobian(problem.first())  # compiles the kernel
            pairs.append((minpack(problem), accelerated(problem)))
        before, after = zip(*pairs, strict=True)
        lower = [b.error / a.error for b, a in pairs]
        rows.append(
            f"| {case.family}, {case.hidden[0]} | {sum(b.jacobians for b in before)} | "
            f"{sum(a.jacobians for a in after)} | "
            f"**{sum(b.seconds for b in before) / sum(a.seconds for a in after):.1f}** | "
            f"{min(lower):.3f}–{max(lower):.3f} |"
        )
    return [
        "## Least squares: MINPACK beside geodesic acceleration",
        "",
        "Six runs on the grid of the searches, all parameters, from where an identification in stages ends; then once "
        f"more with each of {' and '.join(TRIED)}, which the strips do not have. Sums over the three.",
        "",
        "| strip and what it hides | Jacobians, MINPACK | ours | ratio of times | error of MINPACK over ours |",
        "|---|---|---|---|---|",
        *rows,
        "",
    ]
