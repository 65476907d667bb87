# SPDX-License-Identifier: Apache-2.0
"""How far the data leave a fit open: residuals counted as independent ones, and error bands on predictions."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate

from lce_analysis.identification.discontinuities import without_discontinuities
from lce_analysis.identification.problem import Problem
from lce_analysis.prediction import COLUMN, measured_drive, model_of_run, simulation_input, start_temperature, starts_at
from lce_data.channels import Channel
from lce_data.run import Run

Floats = NDArray[np.float64]

LOOSEST: Final = 2.0
"""Standard deviation of z at which a direction of the search is as good as free: z covers its bounds in π, whatever the
parameter, so a larger one would mean nothing."""


def correlation_time(residual: Floats) -> float:
    """Samples per independent sample: 1 + 2 Σρ up to the first correlation inside ±1.96/√N."""
    centred = residual - residual.mean()
    lags = correlate(centred, centred, mode="full", method="fft")[centred.size - 1 :]
    if lags[0] <= 0.0:
        return 1.0
    rho = lags / lags[0]
    inside = np.flatnonzero(rho[1:] < 1.96 / np.sqrt(centred.size))
    end = 1 + int(inside[0]) if inside.size else rho.size
    return max(1.0, 1.0 + 2.0 * float(np.sum(rho[1:end])))


def calibrated(problem: Problem) -> Problem:
    """The problem with weights by which the residuals at its variables count as independent ones of variance 1.

    Each series by its own RMS residual and correlation time: model error counts as correlated noise. Samples around a
    jump of the model do not count: a time constant moves the jump, and would seem known to the time of one sample.
    """
    problem = without_discontinuities(problem)
    residual, begin, observed = problem.residuals(problem.first()), 0, []
    for series in problem.observed:
        part = residual[begin : begin + series.size]
        begin += series.size
        scale = float(np.sqrt(np.sum(part**2) / max(series.counted, 1.0) * correlation_time(part)))
        observed.append(replace(series, weight=series.weight / max(scale, 1e-300)))
    return replace(problem, observed=tuple(observed))


@dataclass(frozen=True)
class Band:
    """A prediction and the half-width of the band in which the model with the true parameters lies, by channel.

    All are (n,) on the grid of the input, in SI units.
    """

    time_s: Floats
    value: Mapping[Channel, Floats]
    error: Mapping[Channel, Floats]


def band(problem: Problem, run: Run, measured: bool = False, level: float = 0.95) -> Band:
    """Laplace's approximation: the curvature at the optimum, carried on to the prediction to first order.

    ``problem`` stands at its optimum (:attr:`FitResult.problem`). The errors are half-widths of bands that hold the
    truth of a model that is right with the probability ``level``, sample by sample; they do not know of what the
    model lacks beyond what correlates the residuals of the fit. ``measured``: the measured temperature drives T→d.
    """
    covariance = _covariance(calibrated(problem))
    model = model_of_run(problem.model, run)
    run_input = simulation_input(run, model)
    start = start_temperature(run_input, model)
    if measured:
        run_input = measured_drive(run_input, model, start)
    c, h = problem.transformation, 1e-4
    z = c.to_search(model.vector[list(problem.free)])
    rows = np.repeat(model.vector[None], 2 * z.size + 1, axis=0)
    rows[1:, list(problem.free)] = c.to_model(z + h * np.vstack([np.eye(z.size), -np.eye(z.size)]))
    starts = np.full(rows.shape[0], start)
    if not run_input.driven and starts_at(run_input, float(run_input.at_rest_k(model, model.vector[None])[0])):
        starts = run_input.at_rest_k(model, rows)
    out = run_input.simulate(model, rows, starts)
    slopes = (out[1 : z.size + 1] - out[z.size + 1 :]) / (2.0 * h)
    spread = NormalDist().inv_cdf(0.5 + 0.5 * level)

    def error(column: int) -> Floats:
        j = slopes[:, :, column]
        return np.asarray(spread * np.sqrt(np.maximum(np.einsum("kn,kl,ln->n", j, covariance, j), 0.0)))

    values = {channel: out[0, :, column] for channel, column in COLUMN.items()}
    return Band(run_input.time_s, values, {channel: error(column) for channel, column in COLUMN.items()})


def _covariance(problem: Problem) -> Floats:
    """Covariance (k, k) of the free parameters as search variables, offsets and start temperatures left open."""
    k = len(problem.free)
    jacobian = problem.penalized_jacobian(problem.first(), central=True)
    own = jacobian[:, :k]
    if jacobian.shape[1] > k:
        q, _ = np.linalg.qr(jacobian[:, k:])
        own = own - q @ (q.T @ own)
    _, singular, rows = np.linalg.svd(own, full_matrices=False)
    spread = 1.0 / np.maximum(singular, 1.0 / LOOSEST)
    return np.asarray((rows.T * spread**2) @ rows)
