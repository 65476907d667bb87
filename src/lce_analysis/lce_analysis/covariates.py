# SPDX-License-Identifier: Apache-2.0
"""What a residual may depend on: the covariates of a run along the model's own trajectory, and a basis for curves.

The trajectory of the model is free of noise, so its direction does not flicker and its path length does not grow
with the noise of the camera.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.identification.problem import ObservedSeries, Problem
from lce_analysis.prediction import SimulationInput
from lce_model.closures.covariates import COVARIATES as KNOWN
from lce_model.closures.covariates import Covariate
from lce_model.kernel.generate import RECORDED

Floats = NDArray[np.float64]


COVARIATES: Final[Mapping[str, Covariate]] = {c.name: c for c in KNOWN if not c.lagged and c.published == c.name}
"""By name."""


def covariates_on_grid(run_input: SimulationInput, out: Floats) -> dict[str, Floats]:
    """The covariates of a run on the grid of its input.

    Parameters
    ----------
    run_input : the run.
    out : (n, len(RECORDED)) what the kernel returned for it, as ``Problem.simulated``.

    Returns
    -------
    dict of str to (n,) arrays
        By the names of :data:`COVARIATES`, in their order. A quantity that the model does not have (the order of a
        model without deformation) or the run does not know (the power of a bare T-d loop) is left out.
    """
    time_s = run_input.time_s
    state = dict(zip(RECORDED, out.T, strict=True))
    temperature, direction = state["temperature"], state["direction"]
    rate = np.gradient(temperature, time_s)
    branch = np.where((direction if np.isfinite(direction).all() else rate) >= 0.0, 1.0, -1.0)
    power = run_input.power_w
    found = {
        "temperature": temperature,
        "rate": rate,
        "power": power,
        "order": state["order"],
        "displacement": state["displacement"],
        "time": time_s,
        "dose": np.concatenate([[0.0], np.cumsum(power[:-1] * np.diff(time_s))]),
        "path": np.concatenate([[0.0], np.cumsum(np.abs(np.diff(temperature)))]),
        "branch": branch,
        "cycle": np.concatenate([[0.0], np.cumsum(np.diff(branch) > 0.0)]),
    }
    unknown = () if run_input.run.power is not None else ("power", "dose")
    return {name: x for name, x in found.items() if name not in unknown and np.isfinite(x).all()}


def covariates_at(problem: Problem, series: ObservedSeries, out: Floats | None = None) -> dict[str, Floats]:
    """The covariates (k,) at the samples of a series, as :func:`covariates_on_grid`.

    Parameters
    ----------
    problem : whose model gives the trajectory.
    series : one of ``problem.observed``.
    out : (n, len(RECORDED)) the simulated run of the series; simulated here if None.
    """
    simulated = problem.simulated(series.run) if out is None else out
    on_grid = covariates_on_grid(problem.inputs[series.run], simulated)
    found = {name: np.asarray(series.sampling(x)) for name, x in on_grid.items()}
    return {**found, "branch": np.where(found["branch"] > 0.0, 1.0, -1.0)}


def hats(x: Floats, knots: Floats) -> Floats:
    """Piecewise linear basis (n, k) over rising knots (k,); beyond the ends they hold, and NaN gives a row of zeros.

    With a single knot it is a constant.
    """
    if knots.size == 1:
        return np.where(np.isfinite(x), 1.0, 0.0)[:, None]
    inside = np.clip(np.nan_to_num(x, nan=knots[0]), knots[0], knots[-1])
    i = np.clip(np.searchsorted(knots, inside, side="right") - 1, 0, knots.size - 2)
    w = (inside - knots[i]) / (knots[i + 1] - knots[i])
    basis = np.zeros((x.size, knots.size))
    rows = np.arange(x.size)
    basis[rows, i] = 1.0 - w
    basis[rows, i + 1] += w
    basis[~np.isfinite(x)] = 0.0
    return basis


def quantile_knots(x: Floats, count: int) -> Floats:
    """At most ``count`` rising knots that hold equal numbers of the finite values of x (n,); 0 if there is none."""
    known = x[np.isfinite(x)]
    return np.unique(np.quantile(known, np.linspace(0.0, 1.0, count))) if known.size else np.zeros(1)
