# SPDX-License-Identifier: Apache-2.0
"""Maximum likelihood of the models that petab-select asks for (see :mod:`peer_search`), on the product's simulator.

* Calibration: Levenberg–Marquardt from the predecessor's optimum. Each effect starts from every value of its grid in
  the library, at 2 %, 20 % and 100 % of its typical strength, with both signs where it has two, and at the strength
  that is best to first order. Starts are ranked by the error that is left once the predecessor's parameters have made
  up for them to first order, the best twelve of them by the error that is then really left. Three are refined, of
  different values of the grid if there are any. A candidate is never worse than its predecessor, which it contains.
* Samples around a jump of the base model are left out for all models, as in the diagnosis: otherwise which side of the
  jump a sample is on, a hundredth of a second, outweighs all else and least squares stops there.
* Noise ``iid``: white and Gaussian, one standard deviation per sensor, estimated with each model.
* Noise ``autoregressive``: the whitening of the product, one filter per sensor for all models. It is estimated from
  what is left of the base's residual when every effect at every start, and the base's own parameters, are fitted to it
  linearly. The base is refitted in that noise, and the noise estimated again.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import correlate

from lce_analysis.identification.discontinuities import without_discontinuities
from lce_analysis.identification.least_squares import levenberg_marquardt
from lce_analysis.identification.problem import Problem, observed_series, start_conditions
from lce_analysis.prediction import simulation_input
from lce_data.channels import SENSORS, Channel
from lce_data.noise import sensor_noise
from lce_data.progress import silent
from lce_data.run import Run
from lce_model import Model
from lce_model.effects import Effect

Floats = NDArray[np.float64]
Noise = Literal["iid", "autoregressive"]

STRENGTHS = (0.02, 0.2, 1.0)
"""Strengths of an effect at the start, in parts of its typical one."""
SCREENED, REFINED = 12, 3
"""Starts of an effect that are simulated with the others' shift, and those of them that are refined."""
FIRST_STEPS, LAST_STEPS, POLISHING = (8,), (60, 30, 30), (200, 100, 100)
"""Steps of least squares, in turns with the standard deviations: of each of these, of the best one, and of a model to
which effects are added."""
LENGTHS = (1.0, 0.4, 0.15, 0.05)
"""Shares of the way to a start that are tried."""
LONGEST_SHIFT = 0.3
"""Longest shift of a search variable before the first step, a tenth of its bounds; and what a typical one is."""
NEGLIGIBLE = 0.05
"""Change of -2 ln L at which least squares ends."""
SAME_SIGMA = 1e-3
"""Relative change of the standard deviations at which they are taken for estimated."""
LONGEST_FILTER = 24


@dataclass(frozen=True)
class Calibrated:
    """A problem at its least squares, weighted by its noise; and the logarithm of its likelihood."""

    problem: Problem
    log_likelihood: float

    @cached_property
    def slopes(self) -> Floats:
        """Jacobian (N, variables) of the residuals."""
        return self.problem.jacobian(self.problem.first())


# the data and the base model


def problem_of(model: Model, runs: Sequence[Run]) -> Problem:
    """The base model beside the runs; each sensor weighted by its sample-to-sample noise to begin with."""
    inputs = [simulation_input(run, model) for run in runs]
    free = tuple(i for i, v in enumerate(model.values) if not v.fixed)
    starts = np.array([i.start_k if np.isfinite(i.start_k) else model["ambient.t_env"] for i in inputs])
    sigma = sensor_noise(runs, [channel for channel in SENSORS if model.predicts(channel)])
    return Problem(model, inputs, free, starts, observed_series(inputs, sigma), *start_conditions(inputs, model))


def with_effect(before: Problem, effect: Effect) -> Problem:
    """The problem with one more effect at its null value; its parameters are free, behind those that were."""
    model = before.model.add(effect.reference)
    shared = [model.index(before.model.values[i].key) for i in before.free]
    own = [i for i, v in enumerate(model.values) if v.term == effect.name and not v.fixed]
    return replace(before, model=model, free=(*shared, *own))


# calibration


def log_likelihood(problem: Problem, variables: Floats) -> float:
    """Of the variables, in the noise by which the series are weighted."""
    residual = problem.residuals(variables)
    scale = sum(series.size * math.log(series.weight) for series in problem.observed)
    return scale - 0.5 * float(residual @ residual) - 0.5 * problem.size * math.log(2.0 * math.pi)


def refined(
    problem: Problem, variables: Floats, noise: Noise, steps: Sequence[int], negligible: float = NEGLIGIBLE
) -> Calibrated:
    """Maximum likelihood from some variables on, by least squares of so many steps.

    For iid noise they take turns with the standard deviations, until these no longer change.
    """
    for iterations in steps:
        variables = levenberg_marquardt(problem, variables, "", silent, iterations, negligible / problem.size).variables
        if noise == "autoregressive":
            break
        channels = dict.fromkeys(series.channel for series in problem.observed)
        sigma = {channel: problem.series_rms(variables, channel) for channel in channels}
        change = max(abs(series.weight * sigma[series.channel] - 1.0) for series in problem.observed)
        observed = tuple(replace(series, weight=1.0 / sigma[series.channel]) for series in problem.observed)
        problem = replace(problem, observed=observed)
        if change < SAME_SIGMA:
            break
    # Not of problem.at(variables).first(), which keeps clear of the bounds.
    return Calibrated(problem.at(variables), log_likelihood(problem, variables))


def calibrated_base(model: Model, runs: Sequence[Run], effects: Sequence[Effect], noise: Noise) -> Calibrated:
    """The base model, in the noise in which it and all that is made of it are judged."""
    problem = problem_of(model, runs)
    base = refined(problem, problem.first(), "iid", LAST_STEPS)
    problem = without_discontinuities(base.problem)
    base = refined(problem, problem.first(), "iid", LAST_STEPS)
    if noise == "autoregressive":
        base = whitened(base, effects)
    return polished(base, noise)


def polished(found: Calibrated, noise: Noise) -> Calibrated:
    """The same model to the last digit, so that what is added to it gets no credit for what it had left."""
    for _ in range(5):
        better = refined(found.problem, found.problem.first(), noise, POLISHING, 1e-3 * NEGLIGIBLE)
        gain = better.log_likelihood - found.log_likelihood
        found = better if gain > 0.0 else found
        if gain < NEGLIGIBLE:
            break
    return found


def calibrate(before: Calibrated, effect: Effect, noise: Noise) -> Calibrated:
    """The model with one more effect, from the best of its starts."""
    after = with_effect(before.problem, effect)
    found = [refined(after, start, noise, FIRST_STEPS) for start in starts(before, after, effect)[:REFINED]]
    found.sort(key=lambda c: -c.log_likelihood)
    best = refined(found[0].problem, found[0].problem.first(), noise, LAST_STEPS)
    return best if best.log_likelihood > before.log_likelihood else Calibrated(after, before.log_likelihood)


def starts(before: Calibrated, after: Problem, effect: Effect) -> list[Floats]:
    """Variables from which the model with one more effect is searched, the most promising first."""
    count = before.slopes.shape[1]
    # Directions that no sensor sees stay where they are.
    held = np.vstack([before.slopes, np.eye(count) / LONGEST_SHIFT])

    def made_up_for(residuals: Floats) -> tuple[Floats, Floats]:
        target = np.pad(-residuals, ((0, 0), (0, count)))
        shifts = np.asarray(np.linalg.lstsq(held, target.T)[0].T, dtype=np.float64)
        return shifts, residuals + shifts @ before.slopes.T

    tried = list(settings(effect, _longest_s(after)))
    _, (here,) = made_up_for(before.problem.residuals(before.problem.first())[None])
    _, left = made_up_for(responses(after, tried))
    spec, weakest = effect.parameter(effect.strength), STRENGTHS[0] * abs(effect.typical - effect.null)
    for setting, change in zip(list(tried), left - here, strict=True):
        step = setting[effect.strength_key] - effect.null
        if abs(step) <= 1.01 * weakest:
            best = effect.null - step * float(change @ here) / max(float(change @ change), 1e-300)
            tried.append(setting | {effect.strength_key: float(np.clip(best, spec.lower, spec.upper))})
    shifts, left = made_up_for(responses(after, tried))
    ranked = np.argsort(np.nan_to_num(np.sum(left**2, axis=1), nan=np.inf), kind="stable")[:SCREENED]
    reached = sorted(
        ((*_reached(after, effect, tried[i], shifts[i]), i) for i in ranked.tolist()), key=lambda found: found[0]
    )
    groups = [tuple(tried[i][f"{effect.name}.{name}"] for name, _ in effect.grid) for *_, i in reached]
    first = [k for k, group in enumerate(groups) if group not in groups[:k]]
    return [reached[k][1] for k in sorted(range(len(reached)), key=lambda k: (k not in first, k))]


def settings(effect: Effect, duration_s: float) -> Iterator[dict[str, float]]:
    """Where the parameters of an effect start: every value of its grid, several strengths, both signs."""
    names = [f"{effect.name}.{name}" for name, _ in effect.grid]
    sides = (1.0,) if effect.parameter(effect.strength).lower >= effect.null else (1.0, -1.0)
    for values in itertools.product(*effect.grid_of(duration_s).values()):
        for part, side in itertools.product(STRENGTHS, sides):
            strength = effect.null + part * side * (effect.typical - effect.null)
            yield dict(zip(names, values, strict=True)) | {effect.strength_key: strength}


def _longest_s(problem: Problem) -> float:
    """Duration of the longest run [s]."""
    return max(float(run_input.time_s[-1]) for run_input in problem.inputs)


def responses(problem: Problem, tried: Sequence[Mapping[str, float]]) -> Floats:
    """Residuals (settings, N) of the problem with some parameters set, all others as they are."""
    there = [replace(problem, model=problem.model.set(setting)) for setting in tried]
    return np.array([one.residuals(one.first()) for one in there])


def _reached(after: Problem, effect: Effect, setting: Mapping[str, float], shift: Floats) -> tuple[float, Floats]:
    """Squared error and variables at the best point of the line to a setting and the shift that makes up for it."""
    shared = len(after.free) - sum(not p.fixed for p in effect.parameters)
    best = math.inf, after.first()
    for length in LENGTHS:
        strength = effect.null + length * (setting[effect.strength_key] - effect.null)
        there = replace(after, model=after.model.set({**setting, effect.strength_key: strength}))
        variables = there.first()
        variables[:shared] += length * np.clip(shift[:shared], -LONGEST_SHIFT, LONGEST_SHIFT)
        variables[len(after.free) :] += length * shift[shared:]
        error = float(np.sum(there.residuals(variables) ** 2))
        if error < best[0]:
            best = error, variables
    return best


# noise


def whitened(base: Calibrated, effects: Sequence[Effect]) -> Calibrated:
    """The base refitted in autoregressive noise, estimated from what no effect explains."""
    for _ in range(2):
        problem = base.problem
        plain = tuple(replace(s, whitening=np.ones(1)) for s in problem.observed)
        problem = replace(problem, observed=plain)
        target = problem.residuals(problem.first())
        columns = [problem.jacobian(problem.first())]
        for effect in effects:
            there = responses(with_effect(problem, effect), list(settings(effect, _longest_s(problem))))
            columns.append((there - target).T)
        table = np.hstack(columns)
        table /= np.maximum(np.linalg.norm(table, axis=0), 1e-12)
        left = target - table @ np.linalg.lstsq(table, target, rcond=1e-10)[0]
        base = refined(_in_noise_of(problem, left), problem.first(), "autoregressive", LAST_STEPS)
    return base


def _in_noise_of(problem: Problem, residual: Floats) -> Problem:
    """The problem, each sensor whitened by the noise of a residual (N,) in the weights of the problem."""
    parts = np.split(residual, np.cumsum([s.size for s in problem.observed])[:-1])
    by_channel: dict[Channel, list[Floats]] = {}
    for series, part in zip(problem.observed, parts, strict=True):
        kept = part if series.keep is None else part[series.keep > 0.0]
        by_channel.setdefault(series.channel, []).append(kept / series.weight)
    noise = {channel: autoregressive(members) for channel, members in by_channel.items()}
    observed = (replace(s, weight=1.0 / noise[s.channel][1], whitening=noise[s.channel][0]) for s in problem.observed)
    return replace(problem, observed=tuple(observed))


def autoregressive(residuals: Sequence[Floats]) -> tuple[Floats, float]:
    """Whitening filter (p + 1,) and standard deviation of the innovations: Yule–Walker, p by Schwarz's criterion."""
    total = sum(r.size for r in residuals)
    longest = min(LONGEST_FILTER, min(r.size for r in residuals) // 10)
    centred = [r - r.mean() for r in residuals]
    lagged = [correlate(r, r, mode="full", method="fft")[r.size - 1 : r.size + longest] for r in centred]
    covariance = np.sum(lagged, axis=0) / total
    tried = []
    for order in range(longest + 1):
        phi = solve_toeplitz(covariance[:order], covariance[1 : order + 1]) if order else np.empty(0)
        innovation = float(covariance[0] - phi @ covariance[1 : order + 1])
        tried.append((total * math.log(innovation) + order * math.log(total), phi, innovation))
    _, phi, innovation = min(tried, key=lambda t: t[0])
    return np.concatenate([[1.0], -phi]), math.sqrt(innovation)
