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

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, NonlinearConstraint, OptimizeResult, differential_evolution, minimize

from lce_control.pid import Gains
from lce_control.tuning.linear import Complex, margins
from lce_control.tuning.options import TuneOptions
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


@dataclass(frozen=True)
class Task:
    """A controller to tune.

    Parameters
    ----------
    name : of the controller.
    box : bounds of the axes of the search, within which the evolution looks. An axis is named NODE.AXIS, with the axes
        kp [unit of the output / unit of the input], ti [s], td [s] and n [1/s]; a node with any has kp.
    steps : the step responses under given gains.
    open_loops : the linearised open loops under given gains, (201,) each, by name.
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
    task: Task, wanted: Requirements, options: TuneOptions, progress: Progress, guess: Parameters | None = None
) -> Tuned:
    """Find the parameters with the smallest J that meet the requirements.

    Parameters
    ----------
    task : what is tuned.
    wanted : the requirements.
    options : how it is searched.
    progress : called after each candidate, with the smallest J so far; what it raises ends the search.
    guess : parameters to begin with, in the place of the evolution.

    Raises
    ------
    LceError
        If no candidate meets the requirements; it names every figure that the best one misses.
    """
    tries = _evolve(task, wanted, options, progress) if guess is None else []
    start = guess if guess is not None else _best(tries, wanted).parameters
    label = f"{task.name} downhill"
    tries += _descend(task, start, wanted, options, options.local_tries, label, progress)
    return _checked(tries, wanted)


def refine(task: Task, start: Tuned, wanted: Requirements, options: TuneOptions, progress: Progress) -> Tuned:
    """Go on from the gains of a search in an experiment, which makes the steps of the task.

    Parameters
    ----------
    task : its steps are those of the experiment.
    start : the result of the search.
    wanted, progress : as of :func:`search`.
    options : of it ``experiments``, ``first_step`` and ``digits``.

    Raises
    ------
    LceError
        If no experiment meets the requirements; it names every figure that the best one misses.
    """
    label = f"{task.name} in the experiment"
    tries = _descend(task, start.parameters, wanted, options, options.experiments, label, progress)
    return _checked(tries, wanted)


def _evolve(task: Task, wanted: Requirements, options: TuneOptions, progress: Progress) -> list[Tuned]:
    """Every candidate of a differential evolution whose step responses were computed."""
    computed: list[Tuned] = []
    generation, best_itae = 0, math.nan

    @cache
    def candidate(x: tuple[float, ...]) -> Tuned:
        progress(task.name, generation, options.generations, best_itae)
        return task.tuned(_parameters(task, x, options.digits))

    def error(x: Floats) -> float:
        return candidate(tuple(x)).itae

    def constraints(x: Floats) -> list[float]:
        # The margins cost next to nothing: the steps are only computed for a loop that has them.
        loops = task.open_loops(_parameters(task, tuple(x), options.digits))
        stable = missing_margins({name: margins(loop) for name, loop in loops.items()}, wanted)
        if max(stable.values()) > 0.0:
            return [*stable.values(), *dict.fromkeys(STEP_FIGURES, 1.0).values()]
        computed.append(candidate(tuple(x)))
        return [*stable.values(), *missing_figures(computed[-1].steps, wanted).values()]

    def note(intermediate_result: OptimizeResult) -> None:  # scipy passes it by this name
        nonlocal generation, best_itae
        generation, best_itae = int(intermediate_result.nit), float(intermediate_result.fun)
        progress(task.name, generation, options.generations, best_itae)

    found = differential_evolution(
        error,
        Bounds(*np.log(np.array(list(task.box.values()))).T),
        constraints=NonlinearConstraint(constraints, -np.inf, 0.0),
        maxiter=options.generations,
        popsize=options.candidates,
        init="sobol",
        rng=np.random.default_rng(options.seed),
        polish=False,
        callback=note,
    )
    return [*computed, candidate(tuple(found.x))]


def _descend(
    task: Task,
    start: Parameters,
    wanted: Requirements,
    options: TuneOptions,
    max_tries: int,
    label: str,
    progress: Progress,
) -> list[Tuned]:
    """Every try of Nelder–Mead. What a try misses of the requirements is added to its error."""
    tries: list[Tuned] = []

    def error(x: Floats) -> float:
        tries.append(task.tuned(_parameters(task, tuple(x), options.digits)))
        progress(label, len(tries), max_tries, _best(tries, wanted).itae)
        return _cost(tries[-1], wanted)

    first = _axes(task, start)
    up_and_down = np.where(np.arange(first.size) % 2, -1.0, 1.0)
    simplex = np.vstack([first, first + options.first_step * np.diag(up_and_down)])
    minimize(error, first, method="Nelder-Mead", options={"maxfev": max_tries, "initial_simplex": simplex})
    return tries


def _cost(tuned: Tuned, wanted: Requirements) -> float:
    return tuned.itae + sum(max(x, 0.0) for x in missing(tuned, wanted).values())


def _best(tries: Sequence[Tuned], wanted: Requirements) -> Tuned:
    """The candidate with the smallest J that meets the requirements; if no candidate meets them, the nearest one."""
    return min(tries, key=lambda t: (max(missing(t, wanted).values()) > 0.0, _cost(t, wanted)))


def _checked(tries: Sequence[Tuned], wanted: Requirements) -> Tuned:
    best = _best(tries, wanted)
    check(best, wanted)
    return replace(best, evaluations=len(tries))


def _parameters(task: Task, x: Sequence[float], digits: int) -> Parameters:
    """ROS parameters, rounded, at a point of the search."""
    axes: dict[str, dict[str, float]] = {}
    for name, value in zip(task.box, np.exp(x).tolist(), strict=True):
        node, _, axis = name.partition(".")
        axes.setdefault(node, {})[axis] = value
    return {node: _rounded_gains(own, digits) for node, own in axes.items()}


def _rounded_gains(axes: Mapping[str, float], digits: int) -> dict[str, float]:
    kp = axes["kp"]
    exact = {"kp": kp, "ki": kp / axes["ti"], "kd": kp * axes["td"]}
    if "n" in axes:
        exact["n"] = axes["n"]
    return {name: float(f"{x:.{digits}g}") for name, x in exact.items()}


def _axes(task: Task, parameters: Parameters) -> Floats:
    """The point of the search that belongs to parameters."""
    found = []
    for name in task.box:
        node, _, axis = name.partition(".")
        own = parameters[node]
        values = {"ti": own["kp"] / own["ki"], "td": own["kd"] / own["kp"], **own}
        found.append(math.log(values[axis]))
    return np.array(found)
