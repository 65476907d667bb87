# SPDX-License-Identifier: Apache-2.0
"""Where a model jumps its slopes say nothing: the samples around a jump are left out of whatever is linearised."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_analysis.jumps import LEFT_OUT_S, away_from, discontinuities
from lce_analysis.prediction import COLUMN, MECHANICAL, STATE, Sampling, SimulationInput

UNRESOLVED: Final = 0.5
"""A sample that a coarser grid gets wrong by more than this share of its sensor's noise does not count on it."""
EITHER_SIDE: Final = 3.0
"""Around a jump an error counts as at most so many times the noise: which side a sample is on says no more."""
JUMPS_AT: Final = "dynamic.t_star"
"""The parameter that says at which temperature the dynamic model jumps on cooling (§5.1)."""
SAME_JUMP_S: Final = 5.0
"""Jumps of the strip and of the model that are farther apart than this [s] are not the same one."""


def without_discontinuities(problem: Problem, recorded: Sequence[SimulationInput] = ()) -> Problem:
    """The problem without the samples around a jump of the model, in each series from behind the temperature.

    Models with a branch for each direction jump where the temperature turns inside the loop. Which side of the jump a
    sample is on is decided within a hundredth of a second, and would outweigh all the rest.

    recorded : of a problem on a coarser grid, the runs as they were recorded. The jumps are those on these, and samples
        of a motion that the coarser grid does not resolve are left out, too.
    """
    fine = replace(problem, inputs=recorded) if recorded else problem
    observed = []
    for series in problem.observed:
        if series.channel in MECHANICAL:
            column, time = COLUMN[series.channel], problem.inputs[series.run].time_s
            fine_time, fine_modelled = fine.inputs[series.run].time_s, fine.simulated(series.run)[:, column]
            jumps = discontinuities(fine_time, fine_modelled, 1.0 / series.weight)
            counted = away_from(jumps, series.sampling(time))
            if recorded:
                there = Sampling.between(fine_time, series.sampling(time))(fine_modelled)
                wrong = np.abs(series.sampling(problem.simulated(series.run)[:, column]) - there)
                counted &= wrong * series.weight <= UNRESOLVED
            if not counted.all():
                keep = counted.astype(np.float64)
                series = replace(series, keep=keep if series.keep is None else keep * series.keep)
        observed.append(series)
    return replace(problem, observed=tuple(observed))


def squared_error(problem: Problem, recorded: Sequence[SimulationInput] = ()) -> float:
    """Squared error in units of the noise, each sample around a jump of the strip or of the model with a bounded one.

    So a sample on the wrong side of a jump counts for little, and a jump at the wrong time for as much as it lasts. The
    error of a sample that a coarser grid does not resolve is bounded, too.

    recorded : as of :func:`without_discontinuities`.
    """
    every = replace(problem, observed=tuple(replace(series, keep=None) for series in problem.observed))
    squared = every.residuals(every.first()) ** 2
    away = without_discontinuities(problem, recorded).observed
    counted = np.concatenate([np.ones(s.size) if s.keep is None else s.keep[s.whitening.size - 1 :] for s in away])
    return float(np.sum(np.where(counted > 0.0, squared, np.minimum(squared, EITHER_SIDE**2))))


def jumping_with_the_strip(problem: Problem, recorded: Sequence[SimulationInput] = ()) -> Problem | None:
    """The problem with T* where the strip jumps on cooling.

    A refit does not find it: the samples between a jump of the strip and one of the model, too far apart to be left out
    together, are off by the whole jump, and no small change of T* makes that less.

    recorded : as of :func:`without_discontinuities`.

    Returns None if no jump of the model is a little earlier or later than one of the strip, or if T* is not free or
    differs from run to run.
    """
    model = problem.model
    if JUMPS_AT not in model or model.index(JUMPS_AT) not in problem.free or JUMPS_AT in model.varies:
        return None
    fine = replace(problem, inputs=recorded) if recorded else problem
    apart_k = [x for series in problem.observed if series.channel in MECHANICAL for x in _apart_k(fine, series)]
    if not apart_k:
        return None
    spec = model.values[model.index(JUMPS_AT)]
    t_star = float(np.clip(spec.value + np.median(apart_k), spec.lower, spec.upper))
    return replace(problem, model=model.set({JUMPS_AT: t_star}))


def _apart_k(problem: Problem, series: ObservedSeries) -> list[float]:
    """By how much [K] the modelled temperature at jumps of a measured series exceeds that at jumps of the model."""
    measured, noise = problem.inputs[series.run].run.series[series.channel], 1.0 / series.weight
    strip = discontinuities(measured.time_s, measured.value, noise)
    if not strip.size:
        return []
    time, out = problem.inputs[series.run].time_s, problem.simulated(series.run)
    temperature = out[:, STATE["temperature"]]
    slope = np.gradient(temperature, time)
    modelled = discontinuities(time, out[:, COLUMN[series.channel]], noise)
    modelled = modelled[np.interp(modelled, time, slope) < 0.0]
    apart_k = []
    for jump in strip[np.interp(strip, time, slope) < 0.0] if modelled.size else ():
        nearest = modelled[np.argmin(np.abs(modelled - jump))]
        if LEFT_OUT_S < abs(nearest - jump) < SAME_JUMP_S:
            at_strip, at_model = np.interp([jump, nearest], time, temperature)
            apart_k.append(float(at_strip - at_model))
    return apart_k
