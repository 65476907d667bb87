# SPDX-License-Identifier: Apache-2.0
"""What a fit ends with: a model with standard errors, what the data leave open, and a record for the model file."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lce_model
from lce_analysis.comparison.metrics import nrmse
from lce_analysis.identification.identifiability import Identifiability, identifiability
from lce_analysis.identification.problem import Problem
from lce_analysis.identification.random_effects import with_run_errors
from lce_analysis.identification.summary import summary
from lce_analysis.identification.uncertainty import calibrated
from lce_analysis.options import Drive, FitOptions
from lce_analysis.prediction import predict
from lce_data import __version__
from lce_data.run import Run
from lce_model import Model

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FitResult:
    """An identified model and what is known of it.

    Attributes
    ----------
    model : with the values found, their standard errors, and the record of the fit.
    starts_k : start temperature [K] of each run.
    identifiability : of the free parameters, None if the fit was interrupted before it.
    evaluations : simulations of the whole data set.
    interrupted : did the user end the fit? Then the model has the best values so far.
    problem : the least squares that it solves, standing at its optimum; from which profiles and error bands start.
    """

    model: Model
    starts_k: Floats
    identifiability: Identifiability | None
    evaluations: int
    interrupted: bool
    problem: Problem

    @classmethod
    def from_problem(
        cls,
        problem: Problem,
        runs: Sequence[Run],
        starts_k: Floats,
        options: FitOptions = FitOptions(),
        evaluations: int = 0,
        interrupted: bool = False,
    ) -> "FitResult":
        """The result of a problem that stands at its least squares: standard errors, and the record of the fit."""
        problem = problem if interrupted or not problem.varying else with_run_errors(problem)
        report = None if interrupted else _uncertainty(problem, options)
        values = _annotated(problem.model, problem, report)
        record = _record(problem.model, runs, starts_k, options.drive, report, interrupted)
        return cls(problem.model.with_values(values, record), starts_k, report, evaluations, interrupted, problem)

    def summary(self) -> str:
        """The parameters with their standard errors, what the data leave open, and the error of each run, as text."""
        return summary(self.model, self.identifiability)


def _uncertainty(problem: Problem, options: FitOptions) -> Identifiability:
    """Standard errors from the Jacobian at the optimum, each series scaled by its own residual and correlation."""
    variables = problem.first()
    jacobian = calibrated(problem).penalized_jacobian(variables, central=True)
    k, c = len(problem.free), problem.transformation
    natural = jacobian[:, :k] / np.maximum(c.natural_per_search(problem.split(variables)[0]), 1e-9)
    if jacobian.shape[1] > k:
        q, _ = np.linalg.qr(jacobian[:, k:])
        natural -= q @ (q.T @ natural)
    keys = [problem.model.values[i].key for i in problem.free]
    return identifiability(natural, keys, c.multiplicative, options.undetermined, options.strong_correlation)


def _annotated(model: Model, problem: Problem, report: Identifiability | None) -> tuple[lce_model.Value, ...]:
    values = list(model.values)
    if report is None:
        return tuple(values)
    slope = problem.transformation.natural_slope(model.vector[list(problem.free)])
    for j, i in enumerate(problem.free):
        known = bool(report.determined[j])
        error = float(report.standard_errors[j] * slope[j]) if known else None
        values[i] = replace(values[i], standard_error=error, determined=known)
    return tuple(values)


def _record(
    model: Model, runs: Sequence[Run], starts: Floats, drive: Drive, report: Identifiability | None, interrupted: bool
) -> dict[str, Any]:
    """What the model file keeps of the fit: data, metrics, software."""
    entries = []
    for run, start in zip(runs, starts, strict=True):
        prediction = predict(model, run, drive)
        entry: dict[str, Any] = {"name": run.name, "sha256": run.sha256, "start_temperature_k": round(float(start), 4)}
        for channel, modelled in prediction.at_samples.items():
            entry[f"{channel.name}_nrmse"] = round(nrmse(modelled, run.series[channel].value), 6)
        entries.append(entry)
    digest = hashlib.sha256("".join(sorted(r.sha256 for r in runs)).encode()).hexdigest()
    return {
        "software": f"lce {__version__}",
        "drive": drive,
        "interrupted": interrupted,
        "data_sha256": digest,
        "runs": entries,
        "not_determined": [] if report is None else list(report.sentences),
    }
