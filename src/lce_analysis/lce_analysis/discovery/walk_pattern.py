# SPDX-License-Identifier: Apache-2.0
"""What a walk looks like in time: a period, steps, or neither but a correlation over some seconds.

All three are judged on the data, not on the smoothed path: a wave or a few steps of the parameter must take as much of
the squared error as the walk itself.
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_analysis.discovery.walk_smoother import Smoothed

Floats = NDArray[np.float64]

LEAST_PERIODS: Final = 4.0
"""The longest run must hold a period so many times, or it does not count as one."""
FINENESS: Final = 4.0
"""Frequencies tried for each one over the duration of the longest run."""
RIDGE: Final = 1e-9
"""Of the inner products of steps, in parts of their mean: steps of one interval after the other look alike."""
STEP_PRICE: Final = 2.0
"""Numbers that a step takes: its time and its height."""


@dataclass(frozen=True)
class Pattern:
    """How a walk goes on in time.

    kind : "period", "steps" or "correlated".
    seconds : the period, the median time between two steps of a run (infinite if there is one at most), or the
        correlation time [s].
    share : of what the walk takes of the squared error, that a wave of this period or these steps take.
    """

    kind: Literal["period", "steps", "correlated"]
    seconds: float
    share: float


def pattern(walk: Smoothed, periodic: float) -> Pattern:
    """The plainest pattern that serves as well as the walk; a period must take the share ``periodic`` of it."""
    period_s, share = _period(walk)
    if share >= periodic:
        return Pattern("period", period_s, share)
    between_s, gain, share = _steps(walk)
    if gain >= walk.ln_gain:
        return Pattern("steps", between_s, share)
    return Pattern("correlated", walk.correlation_s, 1.0)


def _period(walk: Smoothed) -> tuple[float, float]:
    """The best period [s] of a wave with an amplitude and a phase for each run, and the share that it takes."""
    longest = max(float(run.edges_s[-1]) for run in walk.runs)
    shortest = 4.0 * max(float(run.edges_s[1] - run.edges_s[0]) for run in walk.runs)
    frequencies = np.arange(LEAST_PERIODS / longest, 1.0 / shortest, 1.0 / (FINENESS * longest))
    if frequencies.size == 0:
        return np.inf, 0.0
    gains = np.zeros(frequencies.size)
    for run, rest in zip(walk.runs, walk.walked, strict=True):
        phase = 2.0 * np.pi * np.outer(run.middles_s, frequencies)
        responses = run.responses[walk.parameter]
        for i, (s, c) in enumerate(zip((responses @ np.sin(phase)).T, (responses @ np.cos(phase)).T, strict=True)):
            columns = np.column_stack([s, c])
            gram, moment = columns.T @ columns, columns.T @ rest
            gains[i] += float(moment @ np.linalg.pinv(gram, rcond=1e-9) @ moment)
    best = int(np.argmax(gains))
    total = sum(float(rest @ rest) for rest in walk.walked) - sum(float(rest @ rest) for rest in walk.remains)
    return float(1.0 / frequencies[best]), float(gains[best] / total)


def _steps(walk: Smoothed) -> tuple[float, float, float]:
    """Median time [s] between two steps, what they gain in ln likelihood less their price, and the share they take."""
    after, price, gaps = 0.0, 0.0, []
    for run, rest in zip(walk.runs, walk.walked, strict=True):
        steps = np.cumsum(run.responses[walk.parameter][:, ::-1], axis=1)[:, ::-1]
        chosen, left = _chosen(steps, rest, walk.s2)
        gaps += list(np.diff(_merged(run.edges_s[chosen], float(run.edges_s[1]))))
        after += left
        price += 0.5 * STEP_PRICE * len(chosen) * float(np.log(rest.size))
    between = float(np.median(gaps)) if gaps else float("inf")
    before = sum(float(rest @ rest) for rest in walk.without)
    size = sum(rest.size for rest in walk.without)
    gain = 0.5 * size * float(np.log(before / max(after, 1e-300))) - price
    return between, gain, (before - after) / float(walk.reductions.sum())


def _merged(times_s: Floats, width_s: float) -> Floats:
    """Rising times; of neighbours, which are one step between two edges, the mean."""
    ordered = np.sort(times_s)
    groups = np.split(ordered, np.flatnonzero(np.diff(ordered) > 1.5 * width_s) + 1)
    return np.array([group.mean() for group in groups if group.size])


def _chosen(columns: Floats, rest: Floats, s2: float) -> tuple[list[int], float]:
    """Columns that are worth their price, and the squared error that they leave.

    All are there to begin with; again and again the one goes that takes least.
    """
    gram, moment = columns.T @ columns, columns.T @ rest
    ridge = RIDGE * float(np.mean(np.diag(gram)))
    inverse: Floats = np.asarray(np.linalg.inv(gram + ridge * np.eye(moment.size)), dtype=np.float64)
    left = list(range(moment.size))
    price = s2 * STEP_PRICE * float(np.log(rest.size))
    while left:
        heights = inverse @ moment[left]
        taken = heights**2 / np.diag(inverse)
        least = int(np.argmin(taken))
        if taken[least] > price:
            break
        column = inverse[:, least].copy()
        inverse -= np.outer(column, column) / column[least]
        inverse = np.delete(np.delete(inverse, least, axis=0), least, axis=1)
        del left[least]
    chosen = columns[:, left]
    return left, float(np.sum((rest - chosen @ np.linalg.lstsq(chosen, rest, rcond=None)[0]) ** 2))
