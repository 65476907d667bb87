# SPDX-License-Identifier: Apache-2.0
"""Where something is missing, and on what it depends: one examination of every place and every covariate, no refit.

To one place of the model (:mod:`lce_model.closures`) an unknown function of one covariate z is added, Σ w_k φ_k(z)
with hats φ_k over K knots. With the residual r of the fitted model and the directions g_k = ∂f/∂w_k, in units of the
sensors' noise, M = I - J(JᵀJ)⁻¹Jᵀ, which projects the free parameters out, A = GᵀMG/s², b = GᵀMr/s² and the prior
w ~ N(0, V), V = σ_w² C, the evidence for the function against none is

    ln E = ½ bᵀ(A + V⁻¹)⁻¹ b - ½ ln det(I + A V),

maximised over σ_w. C is that of a smooth curve. s² is the variance of what the best function leaves, and counts that
neighbouring samples are alike: it comes from sums over blocks of time, as the errors of strengths do. A covariate that
is tried with n time constants of a lag loses ln n.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from lce_analysis.covariates import covariates_on_grid
from lce_analysis.diagnosis.linearized_fit import LinearizedFit, spans
from lce_analysis.diagnosis.projection import RANK
from lce_analysis.diagnosis.stage_problem import StageProblem
from lce_analysis.identification.problem import Problem
from lce_analysis.options import DiscoverOptions
from lce_analysis.prediction import AMBIENT_KEY
from lce_analysis.unknown_function import Candidate, directions, ends
from lce_data.progress import Progress
from lce_model.closures import PLACES, closure
from lce_model.closures.covariates import COVARIATES, NUMBER
from lce_model.closures.forms import KNOTS
from lce_model.lag import lagged

Floats = NDArray[np.float64]

SMOOTH: Final = 0.35
"""Correlation length of the curve, as a share of the range of its covariate."""
WIDTHS: Final = np.geomspace(1e-2, 1e6, 65)
"""Prior standard deviations σ_w that are tried, in units of the size at which a function is just worth noticing."""
ABSORBED: Final = 1e-3
"""Visibility below which the free parameters of the model do what a part of the curve does."""
VISITED: Final = 1e-3
"""Share of the weight of the data, as even as it could be, below which a knot was not visited."""
BLOCK_S: Final = 10.0
"""Length [s] of a block of time; see :mod:`lce_analysis.diagnosis.strength`."""
PLACES_OF: Final[dict[str, tuple[str, ...]]] = {
    "heat": ("light", "heat", "temperature_sensor"),
    "deformation": ("order", "strain", "displacement_sensor"),
    "both": tuple(place.name for place in PLACES),
}
"""Places that are looked for in the misfit of a part of the model."""


@dataclass(frozen=True)
class Moments:
    """Inner products of the directions (K, N) of a candidate and the residual, in units of the noise.

    before : (K, K) GᵀG. gram : (K, K) GᵀMG. moment : (K,) GᵀMr.
    """

    candidate: Candidate
    before: Floats
    gram: Floats
    moment: Floats

    @cached_property
    def visited(self) -> NDArray[np.intp]:
        """The knots near which the model has been in these runs."""
        weight = np.diag(self.before)
        return np.flatnonzero(weight > VISITED * weight.sum() / weight.size)

    @cached_property
    def seen(self) -> Floats:
        """(K, K) the projection that takes away what the free parameters absorb of a curve.

        A knot that was not visited is set to what a smooth curve through the others has there.
        """
        knots, own = np.arange(KNOTS), self.visited
        metric = self.before[np.ix_(own, own)]
        metric = metric + 1e-9 * np.trace(metric) / max(own.size, 1) * np.eye(own.size)
        visibility, parts = eigh(self.gram[np.ix_(own, own)], metric)
        hidden = parts[:, visibility < ABSORBED]
        smooth = _alike(knots, own) @ np.linalg.inv(_alike(own, own))
        smooth[own] = np.eye(own.size)
        onto = np.zeros((KNOTS, KNOTS))
        onto[:, own] = smooth @ (np.eye(own.size) - hidden @ (hidden.T @ metric))
        return onto

    def absorbs(self, values: Floats) -> bool:
        """Do the free parameters do what a curve with these values (K,) does?"""
        energy = float(values @ self.before @ values)
        return energy > 0.0 and float(values @ self.gram @ values) < ABSORBED * energy


@dataclass(frozen=True)
class Examined:
    """What the data say of a function before any refit.

    weights : (K,) the most likely curve, in the unit of its place; covariance : (K, K) of it.
    gain : of the squared error, in units of the noise, that it promises.
    ln_evidence : against no function.
    """

    moments: Moments
    weights: Floats
    covariance: Floats
    gain: float
    ln_evidence: float

    @property
    def candidate(self) -> Candidate:
        """Which function."""
        return self.moments.candidate

    @property
    def seen(self) -> tuple[Floats, Floats]:
        """The curve (K,) and its covariance (K, K), less what the free parameters absorb of it."""
        onto = self.moments.seen
        return onto @ self.weights, onto @ self.covariance @ onto.T


@dataclass(frozen=True)
class Examination:
    """Every function in a part of the model, the strongest evidence first.

    error : squared residual, in units of the noise.
    variance : s² of the residual that the best function leaves, neighbouring samples being alike.
    """

    stage: StageProblem
    projected: "Projected"
    examined: tuple[Examined, ...]
    error: float
    variance: float


def candidates(problem: Problem, places: Sequence[str], options: DiscoverOptions) -> Iterator[Candidate]:
    """Every place with every covariate that changes in these runs."""
    runs = [_covariates(problem, i, options) for i in range(len(problem.inputs))]
    ambient = {v.key: v.value for v in problem.model.values}.get(AMBIENT_KEY, 0.0)
    for name, tau_s in (key for key in runs[0] if all(key in run for run in runs)):
        between = ends(name, np.concatenate([run[name, tau_s] for run in runs]))
        if between is not None:
            for place in (p for p in PLACES if p.name in places):
                reference = ambient if name == "temperature" else 0.0
                yield Candidate(place, COVARIATES[NUMBER[name]], tau_s, *between, reference)


def _covariates(problem: Problem, run: int, options: DiscoverOptions) -> dict[tuple[str, float | None], Floats]:
    """Covariates (n,) of a run on its grid, by name and time constant of the lag."""
    run_input = problem.inputs[run]
    plain = covariates_on_grid(run_input, problem.simulated(run))
    found: dict[tuple[str, float | None], Floats] = {(name, None): x for name, x in plain.items()}
    if "displacement" in plain:
        moved = np.abs(np.diff(plain["displacement"]))
        found["displacement_path", None] = np.concatenate([[0.0], np.cumsum(moved)])
    for covariate in (c for c in COVARIATES if c.lagged):
        kind, _, of = covariate.name.partition("_")
        if of in plain:
            now = np.ascontiguousarray(plain[of])
            for tau_s in options.lags_s:
                late = lagged(run_input.time_s, now, tau_s, of == "power")
                found[covariate.name, tau_s] = late if kind == "late" else now - late
    return found


@dataclass(frozen=True)
class Projected:
    """A fitted model's residual, and the space of its free parameters, which is projected out of every function.

    basis : (N, rank) orthonormal, of the free parameters; rest : (N,) measured minus model, projected.
    here : (N,) weighted outputs of the model; block : (N,) the block of time of each residual.
    """

    problem: Problem
    basis: Floats
    rest: Floats
    here: Floats
    block: NDArray[np.intp]

    @classmethod
    def of(cls, fit: LinearizedFit) -> "Projected":
        """Of a model at its least squares."""
        left, size, _ = np.linalg.svd(
            fit.jacobian / np.maximum(np.linalg.norm(fit.jacobian, axis=0), 1e-300), full_matrices=False
        )
        basis = left[:, size**2 > RANK * float(size[0]) ** 2] if size.size else left
        block = np.empty(fit.residual.size, np.intp)
        blocks = 0
        for (begin, end), series in zip(spans(fit.problem.observed), fit.problem.observed, strict=True):
            time = series.sampling(fit.problem.inputs[series.run].time_s)[begin - end :]
            block[begin:end] = blocks + ((time - time[0]) // BLOCK_S).astype(np.intp)
            blocks = int(block[end - 1]) + 1
        here = fit.problem.response(fit.problem.model.vector[None])[0]
        return cls(fit.problem, basis, basis @ (basis.T @ fit.residual) - fit.residual, here, block)

    def without_free(self, rows: Floats) -> Floats:
        """Rows (m, N) with the free parameters projected out."""
        return rows - (rows @ self.basis) @ self.basis.T

    def directions(self, candidate: Candidate) -> Floats:
        """(K, N) change of the weighted outputs per unit of each weight."""
        return directions(self.problem, candidate, self.here)

    def moments(self, candidate: Candidate) -> Moments:
        """Inner products, before and after the free parameters are projected out."""
        raw = self.directions(candidate)
        left = self.without_free(raw)
        return Moments(candidate, raw @ raw.T, left @ left.T, left @ self.rest)


def examine(stage: StageProblem, options: DiscoverOptions, progress: Progress) -> Examination:
    """Examine every function in the places of this part of the model, whose closures its model holds at zero."""
    projected = Projected.of(stage.fit)
    held = {term.name for term in projected.problem.model.terms}
    places = [p for p in PLACES_OF[stage.part] if closure(p).name in held]
    todo = list(candidates(projected.problem, places, options))
    moments = []
    for i, candidate in enumerate(todo):
        progress("unknown functions", i, len(todo), float("nan"))
        moments.append(projected.moments(candidate))
    error = float(projected.rest @ projected.rest)
    variance = error / projected.rest.size
    for _ in range(2):
        weighed_all = (weighed(m, variance, 1 if m.candidate.tau_s is None else len(options.lags_s)) for m in moments)
        examined = sorted(weighed_all, key=lambda e: -e.ln_evidence)
        if examined:
            variance = _variance(projected, examined[0])
    return Examination(stage, projected, tuple(examined), error, variance)


def _variance(projected: Projected, best: Examined) -> float:
    """Variance of the residual that the best function leaves, as the sums over blocks of time show it."""
    left = projected.without_free(projected.directions(best.candidate))
    rest = projected.rest - best.weights @ left
    scores = np.zeros((int(projected.block.max()) + 1, left.shape[0]))
    np.add.at(scores, projected.block, (left * rest).T)
    plain = float(rest @ rest) / rest.size
    energy = float(np.sum(left**2))
    return max(plain, float(np.sum(scores**2)) / energy) if energy > 0.0 else plain


def weighed(moments: Moments, variance: float, tried: int = 1) -> Examined:
    """The most likely curve, and the evidence for it at the most likely prior width.

    variance : s². tried : in how many ways its covariate is tried, each as likely as the others.
    """
    gram, moment = moments.gram / variance, moments.moment / variance
    factor = prior_factor()
    size, axes = np.linalg.eigh(factor.T @ gram @ factor)
    size, turned = np.maximum(size, 0.0), axes.T @ (factor.T @ moment)
    widths = closure(moments.candidate.place.name).parameter("w_1").knee * WIDTHS
    wide = widths[:, None] ** 2
    ln_evidence = 0.5 * np.sum(wide * turned**2 / (1.0 + wide * size) - np.log1p(wide * size), axis=1)
    best = int(np.argmax(ln_evidence))
    root = factor @ axes * np.sqrt(wide[best] / (1.0 + wide[best] * size))
    covariance = root @ root.T
    weights = covariance @ moment
    return Examined(
        moments=moments,
        weights=weights,
        covariance=covariance,
        gain=float(2.0 * weights @ moments.moment - weights @ moments.gram @ weights),
        ln_evidence=float(ln_evidence[best]) - math.log(tried),
    )


def prior_factor() -> Floats:
    """(K, K) L with C = L Lᵀ, the prior covariance of a curve of unit width."""
    return np.asarray(np.linalg.cholesky(_alike(np.arange(KNOTS), np.arange(KNOTS))))


def _alike(first: NDArray[np.intp], second: NDArray[np.intp]) -> Floats:
    """C between knots (m,) and (n,): neighbouring knots of a smooth curve are alike."""
    apart = (first[:, None] - second) / (KNOTS - 1)
    return np.asarray(np.exp(-0.5 * (apart / SMOOTH) ** 2) + 1e-4 * (apart == 0.0))
