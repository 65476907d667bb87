# SPDX-License-Identifier: Apache-2.0
"""The simulation–experiment method of §6.3, with a library's optimiser in the place of Simulink Design Optimization.

A candidate is judged by its closed loops to several setpoints. The smallest time-weighted error (ITAE) is sought

    J = max over the steps of  ∫ t |e| dt / ∫ t dt,   e = 1 - y/r

among the candidates that meet the requirements, which are constraints: rise time, settling, overshoot, undershoot, and
the gain and phase margins of the linearised loops. scipy's differential evolution finds where it is on the model,
Nelder–Mead goes on from there, first on the model, then in the experiment; both over logarithms, of K_p,
T_i = K_p/K_i, T_d = K_d/K_p and N.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, NonlinearConstraint, OptimizeResult, differential_evolution, minimize

from lce_control.pid import Gains
from lce_control.tuning.linear import Complex, margins
from lce_control.tuning.requirements import (
    STEP_FIGURES,
    Parameters,
    Requirements,
    Step,
    Tuned,
    check,
    missing,
    missing_figures,
    missing_margins,
)
from lce_data.progress import Progress

Floats = NDArray[np.float64]

GENERATIONS, CANDIDATES, DOWNHILL = 8, 6, 250
"""Of the evolution, candidates in each for every axis; tries of Nelder–Mead on the model."""
SIMPLEX: Final = 0.2
"""First steps of Nelder–Mead: 20 % of each axis, up and down in turn."""
DIGITS: Final = 3


@dataclass(frozen=True)
class Task:
    """A controller to tune: the steps it makes with given parameters, and its open loops.

    ``box`` holds the axes of the search as NODE.AXIS: kp, ti, td, n, kp always; and within which the evolution looks.
    """

    name: str
    box: Mapping[str, tuple[float, float]]
    steps: Callable[[Parameters], tuple[Step, ...]]
    open_loops: Callable[[Parameters], Mapping[str, Complex]]

    def tuned(self, parameters: Parameters) -> Tuned:
        """The controller with these parameters."""
        return Tuned(self.name, parameters, self.steps(parameters), self.open_loops(parameters))


def gains_of(parameters: Mapping[str, float]) -> Gains:
    """The gains among the parameters of a node."""
    return Gains(**{name: parameters[name] for name in ("kp", "ki", "kd", "n") if name in parameters})


def search(
    task: Task, wanted: Requirements, progress: Progress, seed: int = 0, guess: Parameters | None = None
) -> Tuned:
    """The parameters with the smallest J that meet the requirements; LceError where none are found.

    A ``guess`` takes the place of the evolution.
    """
    tries = _evolved(task, wanted, progress, seed) if guess is None else []
    start = guess if guess is not None else _best(tries, wanted).parameters
    return _checked([*tries, *_downhill(task, start, wanted, progress, "downhill", DOWNHILL)], wanted)


def refine(task: Task, start: Tuned, wanted: Requirements, progress: Progress, experiments: int) -> Tuned:
    """Go on from gains of a search in the experiment, whose steps the task makes; LceError as `search`."""
    return _checked(_downhill(task, start.parameters, wanted, progress, "on the bench", experiments), wanted)


def _evolved(task: Task, wanted: Requirements, progress: Progress, seed: int) -> list[Tuned]:
    """Every candidate of a differential evolution whose loops were closed."""

    @cache
    def candidate(x: tuple[float, ...]) -> Tuned:
        return task.tuned(_parameters(task, x))

    closed: list[Tuned] = []

    def error(x: Floats) -> float:
        return candidate(tuple(x)).itae

    def constraints(x: Floats) -> list[float]:
        # The margins cost next to nothing: only a loop that has them is closed.
        loops = task.open_loops(_parameters(task, tuple(x)))
        stable = missing_margins({name: margins(loop) for name, loop in loops.items()}, wanted)
        if max(stable.values()) > 0.0:
            return [*stable.values(), *dict.fromkeys(STEP_FIGURES, 1.0).values()]
        closed.append(candidate(tuple(x)))
        return [*stable.values(), *missing_figures(closed[-1].steps, wanted).values()]

    def told(intermediate_result: OptimizeResult) -> None:  # scipy passes it by this name
        progress(task.name, int(intermediate_result.nit), GENERATIONS, float(intermediate_result.fun))

    progress(task.name, 0, GENERATIONS, math.nan)
    found = differential_evolution(
        error,
        Bounds(*np.log(np.array(list(task.box.values()))).T),
        constraints=NonlinearConstraint(constraints, -np.inf, 0.0),
        maxiter=GENERATIONS,
        popsize=CANDIDATES,
        init="sobol",
        rng=np.random.default_rng(seed),
        polish=False,
        callback=told,
    )
    return [*closed, candidate(tuple(found.x))]


def _downhill(
    task: Task, start: Parameters, wanted: Requirements, progress: Progress, where: str, tries: int
) -> list[Tuned]:
    """Every try of Nelder–Mead; what is missed of the requirements counts as error."""
    done: list[Tuned] = []

    def error(x: Floats) -> float:
        done.append(task.tuned(_parameters(task, tuple(x))))
        progress(f"{task.name} {where}", len(done), tries, _best(done, wanted).itae)
        return _cost(done[-1], wanted)

    first = _axes(task, start)
    simplex = np.vstack([first, first + SIMPLEX * np.diag(np.where(np.arange(first.size) % 2, -1.0, 1.0))])
    minimize(error, first, method="Nelder-Mead", options={"maxfev": tries, "initial_simplex": simplex})
    return done


def _cost(tuned: Tuned, wanted: Requirements) -> float:
    return tuned.itae + sum(max(x, 0.0) for x in missing(tuned, wanted).values())


def _best(tries: Sequence[Tuned], wanted: Requirements) -> Tuned:
    """The smallest J that meets the requirements, or what misses the least of them."""
    return min(tries, key=lambda t: (max(missing(t, wanted).values()) > 0.0, _cost(t, wanted)))


def _checked(tries: Sequence[Tuned], wanted: Requirements) -> Tuned:
    best = _best(tries, wanted)
    check(best, wanted)
    return replace(best, evaluations=len(tries))


def _parameters(task: Task, x: Sequence[float]) -> Parameters:
    """ROS parameters, rounded, of a point of a search."""
    axes: dict[str, dict[str, float]] = {}
    for name, value in zip(task.box, np.exp(x).tolist(), strict=True):
        node, _, axis = name.partition(".")
        axes.setdefault(node, {})[axis] = value
    return {node: _gains(own) for node, own in axes.items()}


def _gains(axes: Mapping[str, float]) -> dict[str, float]:
    kp = axes["kp"]
    exact = {"kp": kp, "ki": kp / axes["ti"], "kd": kp * axes["td"]}
    if "n" in axes:
        exact["n"] = axes["n"]
    return {name: float(f"{x:.{DIGITS}g}") for name, x in exact.items()}


def _axes(task: Task, parameters: Parameters) -> Floats:
    """The point of a search at which parameters are."""
    found = []
    for name in task.box:
        node, _, axis = name.partition(".")
        own = parameters[node]
        values = {"ti": own["kp"] / own["ki"], "td": own["kd"] / own["kp"], **own}
        found.append(math.log(values[axis]))
    return np.array(found)
