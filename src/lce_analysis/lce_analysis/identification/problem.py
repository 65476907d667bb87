# SPDX-License-Identifier: Apache-2.0
"""A fit as numbers: runs and free parameters in, weighted residuals and their Jacobian out."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from lce_analysis.identification.transformation import Transformation
from lce_analysis.prediction import CAMERA, DISTANCE, Sampling, SimulationInput, starts_at
from lce_model import Model

Floats = NDArray[np.float64]

_POOL = ThreadPoolExecutor(max_workers=os.cpu_count() or 1)
"""The kernels release the interpreter lock, so threads use all cores."""


@dataclass(frozen=True)
class ObservedSeries:
    """One measured series of one run: which output it judges, and its weight 1/σ.

    ``whitening`` (p + 1,) is the filter 1 - φ1 z⁻¹ - … of an autoregressive noise; σ is then that of the innovations,
    and the first p samples, which have no past, do not count; nor do those where ``keep`` (n,) is 0; None
    keeps all.
    """

    run: int
    column: int
    sampling: Sampling
    measured: Floats
    weight: float
    whitening: Floats = field(default_factory=lambda: np.ones(1))
    keep: Floats | None = None

    @property
    def size(self) -> int:
        """Number of residuals."""
        return self.measured.size - self.whitening.size + 1

    def weighted(self, values: Floats) -> Floats:
        """Values (…, n) at the samples → (…, size) in units of the noise, whitened."""
        past = self.whitening.size - 1
        white = lfilter(self.whitening, np.ones(1), values)[..., past:] if past else values
        return np.asarray(white * (self.weight if self.keep is None else self.weight * self.keep[past:]))


@dataclass(frozen=True)
class Problem:
    """Weighted least squares of several runs with one parameter set.

    The variables are the free parameters ``free`` (positions in ``model.values``) in the unbounded coordinates, and
    behind them the start temperatures [K] of the runs ``free_starts``. Runs ``at_ambient`` start at the ambient
    temperature, whatever it is; all others at their entry of ``starts_k`` (runs,).
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
        return sum(b.size for b in self.observed)

    def first(self) -> Floats:
        """The variables at the values of the model."""
        z = self.transformation.to_search(self.model.vector[list(self.free)])
        return np.concatenate([z, self.starts_k[list(self.free_starts)]])

    def split(self, variables: Floats) -> tuple[Floats, Floats]:
        """Physical parameters (…, k) and start temperatures (…, runs) of variables (…, k + free starts)."""
        k = len(self.free)
        free = self.transformation.to_model(variables[..., :k])
        starts = np.broadcast_to(self.starts_k, (*variables.shape[:-1], self.starts_k.size)).copy()
        starts[..., list(self.free_starts)] = variables[..., k:]
        if self.at_ambient:
            ambient = self.model.index("ambient.t_env")
            here = free[..., self.free.index(ambient)] if ambient in self.free else self.model.vector[ambient]
            starts[..., list(self.at_ambient)] = np.asarray(here)[..., None]
        return free, starts

    def outputs(self, run: int, free: Floats, start_k: Floats) -> Floats:
        """Kernel outputs (m, n, columns) of one run for rows of free parameters (m, k) and starts (m,)."""
        rows = np.repeat(self.model.vector[None], free.shape[0], axis=0)
        rows[:, list(self.free)] = free
        return self.inputs[run].simulate(self.model, rows, np.ascontiguousarray(start_k))

    def at(self, variables: Floats) -> "Problem":
        """The same problem, its model and start temperatures those of the variables."""
        free, starts = self.split(variables)
        vector = self.model.vector
        vector[list(self.free)] = free
        values = tuple(replace(v, value=float(x)) for v, x in zip(self.model.values, vector, strict=True))
        return replace(self, model=self.model.with_values(values, {}), starts_k=np.array(starts, dtype=np.float64))

    def response(self, rows: Floats) -> Floats:
        """Weighted outputs (m, N) for rows (m, all parameters) at the start temperatures of the problem."""
        starts = np.broadcast_to(self.split(self.first())[1], (rows.shape[0], self.starts_k.size))

        def work(i: int) -> list[Floats]:
            return self._weighted(i, self.inputs[i].simulate(self.model, rows, np.ascontiguousarray(starts[:, i])))

        return self._stack(self._each_run(work))

    def _weighted(self, run: int, out: Floats) -> list[Floats]:
        return [b.weighted(b.sampling(out[:, :, b.column])) for b in self.observed if b.run == run]

    def _modelled(self, run: int, free: Floats, start_k: Floats) -> list[Floats]:
        return self._weighted(run, self.outputs(run, free, start_k))

    def _each_run(self, work: Callable[[int], list[Floats]]) -> list[list[Floats]]:
        return list(_POOL.map(work, range(len(self.inputs))))

    def _stack(self, parts: list[list[Floats]]) -> Floats:
        """Per-run lists back into the order of ``observed``, along the last axis."""
        queues = [iter(p) for p in parts]
        return np.concatenate([next(queues[b.run]) for b in self.observed], axis=-1)

    @cached_property
    def _target(self) -> Floats:
        return np.concatenate([b.weighted(b.measured) for b in self.observed])

    def residuals(self, variables: Floats) -> Floats:
        """(N,) weighted model minus measurement."""
        free, starts = self.split(variables)
        parts = self._each_run(lambda i: [m[0] for m in self._modelled(i, free[None], starts[i : i + 1])])
        return self._stack(parts) - self._target

    def residuals_of(self, run: int, variables: Floats) -> Floats:
        """Those of one run alone."""
        free, starts = self.split(variables)
        parts = self._modelled(run, free[None], starts[run : run + 1])
        measured = [b.weighted(b.measured) for b in self.observed if b.run == run]
        return np.concatenate([m[0] - y for m, y in zip(parts, measured, strict=True)])

    def jacobian(self, variables: Floats, central: bool = False) -> Floats:
        """(N, variables) by forward differences, or central ones at twice the price.

        A start temperature touches its own run only.
        """
        k = len(self.free)
        h = np.concatenate([np.full(k, 1e-6), np.full(variables.size - k, 1e-3)])
        base = 2 * k if central else k
        steps = [np.diag(h)[:k], -np.diag(h)[:k]] if central else [np.diag(h)[:k]]
        free, starts = self.split(variables + np.vstack([*steps, np.zeros((1, variables.size))]))

        def work(i: int) -> list[Floats]:
            rows, begin = free, starts[:, i]
            if i in self.free_starts:
                nudges = np.array([h[-1], -h[-1]])
                rows, begin = np.vstack([free, free[[-1, -1]]]), np.concatenate([begin, begin[-1] + nudges])
            observed = []
            for modelled in self._modelled(i, rows, begin):
                slopes = np.zeros((variables.size, modelled.shape[1]))
                behind = modelled[k:base] if central else modelled[base]
                slopes[:k] = (modelled[:k] - behind) / (h[:k, None] * (2.0 if central else 1.0))
                if i in self.free_starts:
                    slopes[k + self.free_starts.index(i)] = (modelled[-2] - modelled[-1]) / (2.0 * h[-1])
                observed.append(slopes)
            return observed

        return np.ascontiguousarray(self._stack(self._each_run(work)).T)

    def rms_of_rows(self, free: Floats, chunk: int = 16) -> Floats:
        """Weighted RMS residual (m,) of rows of free parameters (m, k); infinite where the model gives no number."""

        def work(begin: int) -> Floats:
            rows = free[begin : begin + chunk]
            total = np.zeros(rows.shape[0])
            for i in range(len(self.inputs)):
                start = np.full(rows.shape[0], self.starts_k[i])
                mine = [b for b in self.observed if b.run == i]
                for block, modelled in zip(mine, self._modelled(i, rows, start), strict=True):
                    total += np.sum((modelled - block.weighted(block.measured)) ** 2, axis=1)
            return np.sqrt(total / self.size)

        rms = np.concatenate(list(_POOL.map(work, range(0, free.shape[0], chunk))))
        return np.where(np.isfinite(rms), rms, np.inf)

    def series_rms(self, variables: Floats, column: int) -> float:
        """RMS residual of one output over all runs, in its own unit; NaN where it was not measured."""
        residual = self.residuals(variables)
        total, count, begin = 0.0, 0, 0
        for b in self.observed:
            part = residual[begin : begin + b.size] / b.weight
            begin += b.size
            if b.column == column:
                total += float(part @ part)
                count += part.size
        return float(np.sqrt(total / count)) if count else float("nan")


def observed_series(
    inputs: Sequence[SimulationInput], temperature_sigma: float | None, displacement_sigma: float | None, thin: int = 1
) -> tuple[ObservedSeries, ...]:
    """The measured series of the runs ; a sigma of None leaves that output out, ``thin`` keeps every n-th."""
    found = []
    for i, prepared in enumerate(inputs):
        for series, sampling, column, sigma in (
            (prepared.run.temperature, prepared.at_temperature, CAMERA, temperature_sigma),
            (prepared.run.displacement, prepared.at_displacement, DISTANCE, displacement_sigma),
        ):
            driven = column == CAMERA and prepared.drive_k.size
            if series is None or sampling is None or sigma is None or driven:
                continue
            thinned = Sampling(sampling.index[::thin], sampling.weight[::thin])
            found.append(ObservedSeries(i, column, thinned, series.value[::thin], 1.0 / sigma))
    return tuple(found)


def with_thermal_state(inputs: Sequence[SimulationInput]) -> tuple[int, ...]:
    """The runs whose measured temperature is predicted."""
    return tuple(i for i, prepared in enumerate(inputs) if prepared.at_temperature and not prepared.drive_k.size)


def start_conditions(inputs: Sequence[SimulationInput], model: Model) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Runs with a start temperature of their own, and runs that start at the ambient temperature."""
    if model.thermal == "none":
        return (), ()
    measured = with_thermal_state(inputs)
    ambient = model["ambient.t_env"]
    rest = tuple(i for i, p in enumerate(inputs) if i not in measured or starts_at(p, ambient))
    return tuple(i for i in measured if i not in rest), rest
