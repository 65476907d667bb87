# SPDX-License-Identifier: Apache-2.0
"""Measured series simulated many times: with parameters that the noise leaves possible, and noise of the sensor."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.comparison.conditions import OperatingConditions, operating_conditions
from lce_analysis.comparison.sensor_process import SensorProcess, sensor_process
from lce_analysis.identification.discontinuities import without_discontinuities
from lce_analysis.identification.parameter_draws import draw_variables
from lce_analysis.identification.problem import Problem
from lce_analysis.options import CompareOptions
from lce_analysis.prediction import COLUMN, STATE, Sampling
from lce_data.channels import Channel
from lce_data.progress import Progress

Floats = NDArray[np.float64]

MOST_SAMPLES: Final = 2000
"""Samples of a series that are looked at; of a longer one, evenly spaced."""
CHUNK: Final = 250_000
"""Samples of a run, times draws, that are simulated at a time."""


def variables_of(problem: Problem, known: Problem, draws: int, seed: int) -> Floats:
    """Variables (draws, all) of a problem, its shared parameters as uncertain as in the problem of the known runs.

    What varies from run to run keeps its values, unless the runs themselves are the known ones.
    """
    if known is problem:
        return draw_variables(_weighed(problem), draws, seed)
    variables = np.repeat(problem.first()[None], draws, axis=0)
    if known.observed:
        shared = [j for j in range(len(problem.free)) if j not in problem.varying]
        variables[:, shared] = draw_variables(_weighed(known), draws, seed)[:, shared]
    return variables


def _weighed(problem: Problem) -> Problem:
    """The problem with weights by which the noise of the sensors, and nothing else, leaves its variables open.

    What the model lacks does not count: it would widen the bands, and hide itself. Samples around a jump of the model
    do not count either.
    """
    noise = _noise(problem, _residuals(problem, [problem.simulated(i) for i in range(len(problem.inputs))]))
    observed = tuple(replace(s, weight=1.0 / noise[s.channel].of_means) for s in problem.observed)
    return without_discontinuities(replace(problem, observed=observed))


def _residuals(problem: Problem, nominal: Sequence[Floats]) -> list[Floats]:
    """Measured minus modelled (n,) of each series [SI]; ``nominal`` are the outputs of the runs."""
    return [s.measured - s.sampling(nominal[s.run][:, COLUMN[s.channel]]) for s in problem.observed]


def _noise(problem: Problem, residuals: Sequence[Floats]) -> dict[Channel, SensorProcess]:
    """The noise of each sensor, from all runs."""
    found = {}
    for channel in dict.fromkeys(s.channel for s in problem.observed):
        mine = [(s, r) for s, r in zip(problem.observed, residuals, strict=True) if s.channel is channel]
        recorded = [problem.inputs[s.run].run.series[channel] for s, _ in mine]
        found[channel] = sensor_process(recorded, [r for _, r in mine])
    return found


@dataclass(frozen=True)
class SimulatedSeries:
    """A series of a run: measured and simulated residuals (k,) and (draws, k), about the model as it is [SI]."""

    run: str
    channel: Channel
    conditions: OperatingConditions
    measured: Floats
    simulated: Floats


def simulated_series(
    problem: Problem, variables: Floats, seed: int, options: CompareOptions, progress: Progress
) -> Iterator[SimulatedSeries]:
    """Each measured series of the problem, simulated with every row of variables and with noise of its sensor."""
    nominal = [problem.simulated(i) for i in range(len(problem.inputs))]
    plans = _plans(problem, nominal, seed)
    chunk = max(1, CHUNK // max(p.time_s.size for p in problem.inputs))
    parts: list[list[Floats]] = [[] for _ in plans]
    with ThreadPoolExecutor() as pool:
        for begin in range(0, variables.shape[0], chunk):
            progress("simulating", begin, variables.shape[0], float("nan"))
            rows = [variables[begin : begin + chunk]] * len(problem.inputs)
            out = list(pool.map(problem.outputs, range(len(problem.inputs)), rows))
            drawn = pool.map(_Plan.residuals, plans, [out[plan.run] for plan in plans])
            for part, residuals in zip(parts, drawn, strict=True):
                part.append(residuals)
    for plan, part in zip(plans, parts, strict=True):
        run_input, temperature = problem.inputs[plan.run], nominal[plan.run][:, STATE["temperature"]]
        course = operating_conditions(run_input.time_s, temperature, run_input.power_w, options)
        here = course.at(run_input.run.series[plan.channel].time_s[:: plan.every])
        yield SimulatedSeries(
            run_input.run.name, plan.channel, here, plan.measured[:: plan.every], np.concatenate(part)
        )


@dataclass(frozen=True)
class _Plan:
    """How a series is simulated: its sampling and its noise.

    about, measured : (k,) what the model shows at the samples as it is, and measured minus that.
    every : of the samples, one in so many is looked at.
    """

    run: int
    channel: Channel
    sampling: Sampling
    about: Floats
    measured: Floats
    every: int
    noise: SensorProcess
    random: np.random.Generator

    def residuals(self, out: Floats) -> Floats:
        """Residuals (m, k/every) of simulated outputs (m, n, columns)."""
        values = self.sampling(out[:, :, COLUMN[self.channel]]) - self.about
        return np.asarray((values + self.noise.draw(self.random, *values.shape))[:, :: self.every])


def _plans(problem: Problem, nominal: Sequence[Floats], seed: int) -> list[_Plan]:
    """One for each series of the problem; ``nominal`` are the outputs of its runs as it stands."""
    residuals = _residuals(problem, nominal)
    noise = _noise(problem, residuals)
    return [
        _Plan(
            run=s.run,
            channel=s.channel,
            sampling=s.sampling,
            about=s.measured - r,
            measured=r,
            every=-(-r.size // MOST_SAMPLES),
            noise=noise[s.channel],
            random=np.random.default_rng((seed, k)),
        )
        for k, (s, r) in enumerate(zip(problem.observed, residuals, strict=True))
    ]
