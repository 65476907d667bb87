# SPDX-License-Identifier: Apache-2.0
"""Parameters that a fit has left at a bound: what the data would want beyond it, and what that would bring."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from lce_analysis.identification.bounds import is_temperature
from lce_analysis.identification.least_squares import levenberg_marquardt
from lce_analysis.identification.problem import Problem
from lce_data.channels import Channel
from lce_data.errors import LceError
from lce_data.progress import Progress, silent
from lce_data.units import after_number
from lce_model import Value

AT: Final = 1e-3
"""Share of its bounds, on its scale, within which a parameter is at one of them."""
WIDER: Final = 10.0
"""Factor by which a bound is moved out; a temperature's by the distance of its bounds."""
ITERATIONS: Final = 15
"""Steps of the least squares beyond the bound, from the optimum within."""
WORTH: Final = 0.01
"""A fall of the NRMSE by less than this share of itself is nothing."""


@dataclass(frozen=True)
class AtBound:
    """A parameter at a bound.

    Attributes
    ----------
    key, unit : TERM.PARAM and its unit.
    side : which bound.
    bound : its value.
    wanted : where the least squares ends with that bound moved out; None if it stays, or cannot be moved.
    wider : the bounds that were tried.
    at_end : is ``wanted`` at the end of those, too?
    before, after : NRMSE of each channel, all runs together, within the bound and beyond it.
    """

    key: str
    unit: str
    side: Literal["lower", "upper"]
    bound: float
    wanted: float | None
    wider: tuple[float, float]
    at_end: bool
    before: Mapping[Channel, float]
    after: Mapping[Channel, float]

    @property
    def option(self) -> str:
        """The option that lets a fit go there."""
        return f"--bounds {self.key}={self.wider[0]:g},{self.wider[1]:g}"

    @property
    def sentence(self) -> str:
        """Which bound it is at, what the data want beyond it, and the option that goes there."""
        unit = after_number(self.unit)
        told = f"{self.key} is at its {self.side} bound, {self.bound:g}{unit}"
        if self.wanted is None:
            return f"{told}; beyond it the fit gains nothing"
        changes = [
            f"{channel.name} NRMSE {self.before[channel]:.2%} → {self.after[channel]:.2%}" for channel in self.after
        ]
        past = f"{'more than ' if self.side == 'upper' else 'less than '}" if self.at_end else ""
        return f"{told}; the data want {past}{self.wanted:.3g}{unit} ({', '.join(changes)}): {self.option}"


def left(problem: Problem) -> dict[Channel, float]:
    """NRMSE of each channel as the problem stands: √(Σe²/Σ(y - ȳ)²) over all runs, ȳ the mean of each run."""
    squared: dict[Channel, list[float]] = {}
    residual, begin = problem.residuals(problem.first()), 0
    for series in problem.observed:
        part = residual[begin : begin + series.size] / series.weight
        begin += series.size
        spread = series.measured.size * float(np.var(series.measured))
        error, total = squared.get(series.channel, [0.0, 0.0])
        squared[series.channel] = [error + float(part @ part), total + spread]
    return {c: math.sqrt(error / total) if total > 0.0 else math.nan for c, (error, total) in squared.items()}


def at_bounds(problem: Problem, progress: Progress = silent, term: str | None = None) -> tuple[AtBound, ...]:
    """What the free parameters at a bound want.

    Every one of them, also where going on would gain nothing. Left out is what rests at a natural end: a strength, a
    time or a share at 0 is simply not there.

    Parameters
    ----------
    problem : at its least squares.
    progress : called after each step; an exception that it raises passes through.
    term : only the parameters of this one.

    Returns
    -------
    tuple of AtBound
        One for each; all other free parameters were fitted anew with it.
    """
    values = [problem.model.values[i] for i in problem.free]
    places = problem.transformation.to_box(np.array([v.value for v in values]))
    found = []
    for value, place in zip(values, places.tolist(), strict=True):
        side: Literal["lower", "upper"] = "lower" if place < 0.5 else "upper"
        if term not in (None, value.term):
            continue
        if AT < place < 1.0 - AT or (side == "lower" and value.lower == value.parameter.least):
            continue
        found.append(_beyond(problem, value, side, progress))
    return tuple(found)


def _beyond(problem: Problem, value: Value, side: Literal["lower", "upper"], progress: Progress) -> AtBound:
    """The least squares with one bound moved out."""
    wider = _wider(value, side)
    bound = value.lower if side == "lower" else value.upper
    before = left(problem)
    stuck = AtBound(value.key, value.unit, side, bound, None, wider, False, before, {})
    try:
        free = replace(problem, model=problem.model.hold({value.key: wider}))
    except LceError:
        return stuck
    optimum = levenberg_marquardt(free, free.first(), f"{value.key} beyond its bound", progress, ITERATIONS)
    if optimum.interrupted:
        raise KeyboardInterrupt
    there = free.at(optimum.variables)
    after = left(there)
    if not any(after[c] < before[c] * (1.0 - WORTH) for c in before):
        return stuck
    wanted = there.model[value.key]
    at_end = abs(wanted - (wider[0] if side == "lower" else wider[1])) <= AT * (wider[1] - wider[0])
    return replace(stuck, wanted=wanted, at_end=at_end, after=after)


def _wider(value: Value, side: Literal["lower", "upper"]) -> tuple[float, float]:
    """The bounds with one of them moved out."""
    lower, upper = value.lower, value.upper
    reach = upper - lower
    if side == "upper":
        out = upper + reach if is_temperature(value) or upper <= 0.0 else upper * WIDER
        return lower, out
    if lower < 0.0 and not is_temperature(value):
        return lower * WIDER, upper
    out = lower / WIDER if value.parameter.scale == "log" else lower - reach
    return max(out, value.parameter.least, 1.0 if is_temperature(value) else -math.inf), upper
