# SPDX-License-Identifier: Apache-2.0
"""A fit as numbers: runs and free parameters in, weighted residuals and their Jacobian out.

A parameter that differs from run to run is a random effect: each run has an offset from the shared value, on the
scale of the search variables, and the offsets are drawn towards zero by their spread (:mod:`lce_model.variation`).
"""

import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from lce_analysis.identification.transformation import Transformation
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.prediction import (
    AMBIENT_KEY,
    COLUMN,
    MECHANICAL,
    Sampling,
    SimulationInput,
    ambient_at_rest,
    starts_at,
)
from lce_data.channels import TEMPERATURE, Channel
from lce_model import Model, RunValue, Variation

Floats = NDArray[np.float64]

LOOSE: Final = 0.5
"""Standard deviation of an offset of which no spread is known yet; z covers the bounds of a parameter in π."""
PARAMETER_STEP: Final = 1e-6
START_STEP_K: Final = 1e-4
"""Steps of the differences: of a parameter as a search variable, and of a start temperature."""

ROWS_AT_ONCE: Final = 16
"""Parameter sets that one thread simulates in one call."""
_CORES: Final = os.cpu_count() or 1
_POOL = ThreadPoolExecutor(max_workers=_CORES)
"""The kernels release the interpreter lock, so threads use all cores."""


@dataclass(frozen=True)
class ObservedSeries:
    """One measured series of one run: of which channel, where it is sampled, and its weight 1/σ.

    ``whitening`` (p + 1,) is the filter 1 - φ1 z⁻¹ - … of an autoregressive noise; σ is then that of the innovations,
    and the first p samples, which have no past, do not count; nor do those where ``keep`` (n,) is 0; None
    keeps all.
    """

    run: int
    channel: Channel
    sampling: Sampling
    measured: Floats
    weight: float
    whitening: Floats = field(default_factory=lambda: np.ones(1))
    keep: Floats | None = None

    @classmethod
    def of(cls, run: int, run_input: SimulationInput, channel: Channel, sigma: float) -> Self:
        """A channel of the run number ``run``; samples around its jumps do not count."""
        series, keep = run_input.run.series[channel], None
        if channel in MECHANICAL:
            jumps = discontinuities(series.time_s, series.value, sigma)
            keep = away_from(jumps, series.time_s).astype(np.float64) if jumps.size else None
        return cls(run, channel, run_input.sampling[channel], series.value, 1.0 / sigma, keep=keep)

    @property
    def size(self) -> int:
        """Number of residuals."""
        return self.measured.size - self.whitening.size + 1

    @property
    def counted(self) -> float:
        """How many residuals count."""
        return float(self.size if self.keep is None else self.keep[self.whitening.size - 1 :].sum())

    def weighted(self, values: Floats) -> Floats:
        """Values (…, n) at the samples → (…, size) in units of the noise, whitened."""
        past = self.whitening.size - 1
        white = lfilter(self.whitening, np.ones(1), values)[..., past:] if past else values
        return np.asarray(white * (self.weight if self.keep is None else self.weight * self.keep[past:]))


@dataclass(frozen=True)
class Problem:
    """Weighted least squares of several runs.

    The variables are the free parameters ``free`` (positions in ``model.values``) as unbounded search variables z;
    behind them, for each of them that varies from run to run, the offsets of z of all runs; and behind those the start
    temperatures [K] of the runs ``free_starts``. Runs ``at_ambient`` start at their ambient temperature, whatever it
    is; all others at their entry of ``starts_k`` (runs,).
    """

    model: Model
    inputs: Sequence[SimulationInput]
    free: tuple[int, ...]
    starts_k: Floats
    observed: tuple[ObservedSeries, ...]
    free_starts: tuple[int, ...] = ()
    at_ambient: tuple[int, ...] = ()

    @cached_property
    def transformation(self) -> Transformation:
        """Of the free parameters."""
        return Transformation.of([self.model.values[i] for i in self.free])

    @property
    def size(self) -> int:
        """Number of residuals."""
        return sum(series.size for series in self.observed)

    @cached_property
    def varying(self) -> tuple[int, ...]:
        """Which of the free parameters vary from run to run: their places in ``free``."""
        return tuple(j for j, i in enumerate(self.free) if self.model.values[i].key in self.model.varies)

    @cached_property
    def _vectors(self) -> tuple[Floats, ...]:
        """All parameters (all,) of each run."""
        return tuple(self.model_of(i).vector for i in range(len(self.inputs)))

    @property
    def offsets(self) -> int:
        """Number of variables that are offsets of a run."""
        return len(self.varying) * len(self.inputs)

    def model_of(self, run: int) -> Model:
        """The model with the values of a run."""
        return self.model.of_run(self.inputs[run].run.name, self.inputs[run].run.sha256)

    def first(self) -> Floats:
        """The variables at the values of the model."""
        z = self._search_variables(self.model)
        return np.concatenate([z, self._first_offsets(z).ravel(), self.starts_k[list(self.free_starts)]])

    def _search_variables(self, model: Model) -> Floats:
        return self.transformation.to_search(model.vector[list(self.free)])

    def _first_offsets(self, z: Floats) -> Floats:
        """Offsets (varying, runs) of the search variables as the model has them."""
        own = [(self._search_variables(self.model_of(i)) - z)[list(self.varying)] for i in range(len(self.inputs))]
        return np.array(own).T if self.varying else np.empty((0, len(self.inputs)))

    def split(self, variables: Floats) -> tuple[Floats, Floats]:
        """Shared parameters (…, k) and start temperatures (…, runs) of variables (…, all)."""
        k = len(self.free)
        free = self.transformation.to_model(variables[..., :k])
        starts = np.broadcast_to(self.starts_k, (*variables.shape[:-1], self.starts_k.size)).copy()
        starts[..., list(self.free_starts)] = variables[..., k + self.offsets :]
        for i in self.at_ambient:
            rows = self._rows(i, self._own(variables, free, i))
            at_rest_k = self.inputs[i].at_rest_k(self.model, rows.reshape(-1, rows.shape[-1]))
            starts[..., i] = at_rest_k.reshape(rows.shape[:-1])
        return free, starts

    def own(self, variables: Floats, run: int) -> Floats:
        """Free parameters (…, k) of one run."""
        k, runs = len(self.free), len(self.inputs)
        z = np.array(variables[..., :k])
        for v, j in enumerate(self.varying):
            z[..., j] += variables[..., k + v * runs + run]
        return np.asarray(self.transformation.to_model(z))

    def _own(self, variables: Floats, free: Floats, run: int) -> Floats:
        """As ``own``, with the shared parameters known: where nothing varies, those of every run."""
        return self.own(variables, run) if self.varying else free

    def simulated(self, run: int) -> Floats:
        """Kernel outputs (n, columns) of one run as the problem stands."""
        variables = self.first()
        start = self.split(variables)[1][run : run + 1]
        return np.asarray(self._outputs(run, self.own(variables, run)[None], start)[0])

    def outputs(self, run: int, variables: Floats) -> Floats:
        """Kernel outputs (m, n, columns) of one run for rows of variables (m, all)."""
        return self._outputs(run, self.own(variables, run), self.split(variables)[1][:, run])

    def _outputs(self, run: int, own: Floats, start_k: Floats) -> Floats:
        """Kernel outputs (m, n, columns) of one run for rows of its free parameters (m, k) and starts (m,)."""
        return self.inputs[run].simulate(self.model, self._rows(run, own), np.ascontiguousarray(start_k))

    def _rows(self, run: int, own: Floats) -> Floats:
        """All parameters (…, all) of one run for its free ones (…, k)."""
        vector = self._vectors[run]
        rows = np.empty((*own.shape[:-1], vector.size))
        rows[...] = vector
        rows[..., list(self.free)] = own
        return rows

    def at(self, variables: Floats) -> "Problem":
        """The same problem, its model and start temperatures those of the variables."""
        free, starts = self.split(variables)
        vector = self.model.vector
        vector[list(self.free)] = free
        values = tuple(replace(v, value=float(x)) for v, x in zip(self.model.values, vector, strict=True))
        model = self.model.with_values(values, {}).varying(self._variations(variables))
        return replace(self, model=model, starts_k=np.array(starts, dtype=np.float64))

    def _variations(self, variables: Floats) -> dict[str, Variation]:
        """What varies, with the value of each of these runs."""
        own = [self.own(variables, i) for i in range(len(self.inputs))]
        found = dict(self.model.varies)
        for j in self.varying:
            key = self.model.values[self.free[j]].key
            by_run = {p.run.name: RunValue(float(o[j])) for p, o in zip(self.inputs, own, strict=True)}
            found[key] = replace(found[key], by_run={**found[key].by_run, **by_run})
        return found

    @property
    def slopes(self) -> Floats:
        """(k,) dp/dz of the free parameters where the problem stands; zero on a bound."""
        p = self.model.vector[list(self.free)]
        return np.asarray(self.transformation.natural_slope(p) * self.transformation.natural_per_search(p))

    @cached_property
    def prior_weight(self) -> Floats:
        """(offsets,) one over the standard deviation of each offset; loose where no spread is known yet."""
        weights = []
        for j in self.varying:
            spread = self.model.varies[self.model.values[self.free[j]].key].spread
            deviation = LOOSE if spread is None else min(spread / max(float(self.slopes[j]), 1e-300), LOOSE)
            weights += [1.0 / max(deviation, PARAMETER_STEP)] * len(self.inputs)
        return np.array(weights)

    def penalized(self, variables: Floats) -> Floats:
        """(N + offsets,) the residuals, and behind them each offset in units of its standard deviation."""
        k = len(self.free)
        return np.concatenate([self.residuals(variables), variables[k : k + self.offsets] * self.prior_weight])

    def penalized_jacobian(self, variables: Floats, central: bool = False, residuals: Floats | None = None) -> Floats:
        """(N + offsets, variables) of :meth:`penalized`; ``residuals`` as of :meth:`jacobian`."""
        jacobian = self.jacobian(variables, central, residuals)
        if not self.varying:
            return jacobian
        prior = np.zeros((self.offsets, variables.size))
        places = len(self.free) + np.arange(self.offsets)
        prior[np.arange(self.offsets), places] = self.prior_weight
        return np.vstack([jacobian, prior])

    def response(self, rows: Floats) -> Floats:
        """Weighted outputs (m, N) for rows (m, all parameters) at the start temperatures of the problem.

        What varies from run to run keeps the value of the run.
        """
        variables = self.first()
        starts = self.split(variables)[1]
        places = [self.free[j] for j in self.varying]

        def response_of_run(i: int) -> list[Floats]:
            own = rows.copy()
            own[:, places] = self.own(variables, i)[list(self.varying)]
            return self._weighted(i, self.inputs[i].simulate(self.model, own, np.full(rows.shape[0], starts[i])))

        return self._stack(self._each_run(response_of_run))

    def _weighted(self, run: int, out: Floats) -> list[Floats]:
        """Weighted outputs (m, size) of the series of one run."""
        mine = [series for series in self.observed if series.run == run]
        return [series.weighted(series.sampling.of_outputs(out, COLUMN[series.channel])) for series in mine]

    def _modelled(self, run: int, own: Floats, start_k: Floats) -> list[Floats]:
        return self._weighted(run, self._outputs(run, own, start_k))

    def _each_run(self, compute: Callable[[int], list[Floats]]) -> list[list[Floats]]:
        return list(_POOL.map(compute, range(len(self.inputs))))

    def _stack(self, parts: list[list[Floats]]) -> Floats:
        """Per-run lists back into the order of ``observed``, along the last axis."""
        queues = [iter(p) for p in parts]
        return np.concatenate([next(queues[series.run]) for series in self.observed], axis=-1)

    @cached_property
    def _target(self) -> Floats:
        return np.concatenate([series.weighted(series.measured) for series in self.observed])

    def residuals(self, variables: Floats) -> Floats:
        """(N,) weighted model minus measurement."""
        free, starts = self.split(variables)
        parts = self._each_run(
            lambda i: [m[0] for m in self._modelled(i, self._own(variables, free, i)[None], starts[i : i + 1])]
        )
        return self._stack(parts) - self._target

    def jacobian(self, variables: Floats, central: bool = False, residuals: Floats | None = None) -> Floats:
        """(N, variables) of the residuals: forward differences, or central ones at twice the cost.

        The forward ones start from the ``residuals`` (N,) at the variables, where these are known already. A start
        temperature touches its own run only. An offset does in its run what the shared variable does there. A run is
        simulated in pieces where there are fewer runs than twice the cores.
        """
        k = len(self.free)
        steps = np.array([PARAMETER_STEP] * k + [START_STEP_K] * len(self.free_starts))
        shifts = np.zeros((steps.size, variables.size))
        shifts[np.arange(steps.size), [*range(k), *range(k + self.offsets, variables.size)]] = steps
        signs = (1.0, -1.0) if central else (1.0,)
        shifted = [variables + sign * shifts for sign in signs]
        rows = [(there, *self.split(there)) for there in shifted]
        here = None if central else (self.residuals(variables) if residuals is None else residuals) + self._target
        out = np.zeros((variables.size, self.size))

        def fill(task: tuple[int, list[int]]) -> None:
            run, columns = task
            modelled = [
                self._modelled(run, self._own(there[columns], free[columns], run), starts[columns, run])
                for there, free, starts in rows
            ]
            span = np.ptp(signs) * steps[columns, None] if central else steps[columns, None]
            for n, place in enumerate(self._places(run)):
                slopes = (modelled[0][n] - (here[place] if here is not None else modelled[1][n])) / span
                out[[c if c < k else c + self.offsets for c in columns], place] = slopes
                for v, j in enumerate(self.varying):
                    if j in columns:
                        out[k + v * len(self.inputs) + run, place] = slopes[columns.index(j)]

        list(_POOL.map(fill, self._tasks()))
        return np.ascontiguousarray(out.T)

    def _tasks(self) -> list[tuple[int, list[int]]]:
        """Pairs of a run and some of the variables that act in it, offsets aside, as places among those."""
        k, pieces = len(self.free), math.ceil(2 * _CORES / len(self.inputs))
        tasks = []
        for i in range(len(self.inputs)):
            columns = [*range(k), *(k + n for n, run in enumerate(self.free_starts) if run == i)]
            if columns:
                tasks += [(i, piece.tolist()) for piece in np.array_split(columns, min(pieces, len(columns)))]
        return tasks

    def _places(self, run: int) -> list[slice]:
        """Where the residuals of each series of a run stand among all."""
        ends = np.cumsum([series.size for series in self.observed]).tolist()
        return [slice(end - s.size, end) for s, end in zip(self.observed, ends, strict=True) if s.run == run]

    def rms_of_rows(self, free: Floats) -> Floats:
        """Weighted RMS residual (m,) of rows of free parameters (m, k); infinite where the model gives no number."""

        def rms_of_chunk(begin: int) -> Floats:
            rows = free[begin : begin + ROWS_AT_ONCE]
            total = np.zeros(rows.shape[0])
            for i in range(len(self.inputs)):
                start = np.full(rows.shape[0], self.starts_k[i])
                mine = [series for series in self.observed if series.run == i]
                for series, modelled in zip(mine, self._modelled(i, rows, start), strict=True):
                    total += np.sum((modelled - series.weighted(series.measured)) ** 2, axis=1)
            return np.sqrt(total / self.size)

        rms = np.concatenate(list(_POOL.map(rms_of_chunk, range(0, free.shape[0], ROWS_AT_ONCE))))
        return np.where(np.isfinite(rms), rms, np.inf)

    def series_rms(self, variables: Floats, channel: Channel) -> float:
        """RMS residual of one channel over all runs, in its SI unit; NaN if it was not measured."""
        residual = self.residuals(variables)
        total, count, begin = 0.0, 0.0, 0
        for series in self.observed:
            part = residual[begin : begin + series.size] / series.weight
            begin += series.size
            if series.channel is channel:
                total += float(part @ part)
                count += series.counted
        return float(np.sqrt(total / count)) if count else float("nan")


def observed_series(inputs: Sequence[SimulationInput], sigma: Mapping[Channel, float]) -> tuple[ObservedSeries, ...]:
    """The measured series of the runs, of the channels in ``sigma``: standard deviations in SI units.

    A temperature that drives the run is an input, and not among them.
    """
    return tuple(
        ObservedSeries.of(i, run_input, channel, sigma[channel])
        for i, run_input in enumerate(inputs)
        for channel in run_input.run.measured
        if channel in sigma and not (channel is TEMPERATURE and run_input.driven)
    )


def with_thermal_state(inputs: Sequence[SimulationInput]) -> tuple[int, ...]:
    """The runs whose measured temperature is predicted."""
    return tuple(i for i, run_input in enumerate(inputs) if TEMPERATURE in run_input.sampling and not run_input.driven)


def start_conditions(inputs: Sequence[SimulationInput], model: Model) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Runs with a start temperature of their own, and runs that start at the ambient temperature.

    Where each run has an ambient temperature of its own, a run that shows no drift before the laser is on starts there.
    """
    if model.thermal == "none":
        return (), ()
    measured = with_thermal_state(inputs)
    if AMBIENT_KEY in model.varies:
        rest = tuple(i for i, p in enumerate(inputs) if i not in measured or ambient_at_rest(p.run) is not None)
    else:
        ambient = [float(p.at_rest_k(model, model.vector[None])[0]) for p in inputs]
        rest = tuple(i for i, p in enumerate(inputs) if i not in measured or starts_at(p, ambient[i]))
    return tuple(i for i in measured if i not in rest), rest
