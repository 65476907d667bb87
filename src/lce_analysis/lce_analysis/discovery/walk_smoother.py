# SPDX-License-Identifier: Apache-2.0
"""The smoother behind a random walk: the levels of a parameter, interval by interval, by maximum likelihood.

The levels p (k,) of a run are a stationary process of first order with correlation time τ, which is a random walk for
times much shorter than τ:

    residual = J shift + H p + e,   p ~ N(0, σ² C),   C_ij = exp(-|t_i - t_j| / τ),   e ~ N(0, s² I)

The extended Kalman filter with the Rauch-Tung-Striebel smoother of Kristensen, Madsen & Jørgensen (2004) solves this
step by step. Responses H that were simulated make it linear, so that it is solved at once, with the same path, the same
band and the same innovations. The free parameters of the fit (J) have a flat prior: a walk gets no credit for what they
could explain. σ² is estimated in units of s², which is profiled out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz, solve_triangular
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter
from scipy.stats import chi2

from lce_analysis.discovery.walk_responses import WalkingParameter, WalkRun

Floats = NDArray[np.float64]

CORRELATION_S: Final = (1.0, 3.0, 10.0, 30.0, 1000.0)
"""Correlation times [s] by which parameters are compared; the last is a random walk for any run of minutes."""
FINE_S: Final = (0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 64.0, 1000.0)
"""Correlation times [s] of the likeliest."""
USUAL_S: Final = 10.0
"""Correlation time [s] of the walks from which the noise is estimated."""
POWERS: Final = (-3.0, 8.0)
"""Bounds of log10 σ²λ/s² that are searched, where λ is the largest information on a level."""
ROUNDS: Final = 2
"""Estimates of the noise on longer intervals."""
LONGEST: Final = 4
"""Highest order of the noise: that of a sensor has a short memory, what is slower is the walk's."""
COARSE: Final = 3
"""Intervals that make one of those."""
REMAINING: Final = tuple(np.arange(-4.0, 0.6, 0.25))
"""Powers of ten of what is left to walk beside a curve, in parts of the walk."""
LAGS: Final = 20
"""Lags of the Ljung–Box test."""
SMALLEST: Final = 1e-9
"""Singular values of the slopes below this part of the largest belong to combinations that the data do not show."""


@dataclass(frozen=True)
class Smoothed:
    """The walk of one parameter at its maximum likelihood.

    runs : whitened by the noise that the likeliest walk leaves, their slopes orthonormal.
    levels : per run, (k,) the smoothed change of the parameter in each interval.
    factors : per run, (k, k) whose product with its transpose is the covariance of the levels.
    ln_gain : ln of the likelihood over that without a walk.
    correlation_s : correlation time τ [s].
    ratio : σ²/s², of the levels and of the noise.
    s2 : s², near 1 as the runs are whitened.
    without, remains : per run, (m,) what the free parameters leave alone, and together with the walk, whitened.
    """

    parameter: WalkingParameter
    runs: tuple[WalkRun, ...]
    levels: tuple[Floats, ...]
    factors: tuple[Floats, ...]
    ln_gain: float
    correlation_s: float
    ratio: float
    s2: float
    without: tuple[Floats, ...]
    remains: tuple[Floats, ...]

    @property
    def bands(self) -> tuple[Floats, ...]:
        """Per run, (k,) standard deviation of the levels."""
        return tuple(np.sqrt(np.sum(factor**2, axis=1)) for factor in self.factors)

    @property
    def intensity(self) -> float:
        """Standard deviation that the walk gains in one second [unit/√s]."""
        return float(np.sqrt(2.0 * self.ratio * self.s2 / self.correlation_s))

    @property
    def walked(self) -> tuple[Floats, ...]:
        """Per run, (m,) what the walk explains, with the noise."""
        explained = (run.responses[self.parameter] @ p for run, p in zip(self.runs, self.levels, strict=True))
        return tuple(rest + moved for rest, moved in zip(self.remains, explained, strict=True))

    @property
    def reductions(self) -> Floats:
        """(runs,) squared error that the walk takes from each run."""
        return np.array([a @ a - b @ b for a, b in zip(self.without, self.remains, strict=True)])

    @cached_property
    def roots(self) -> tuple[Floats, ...]:
        """Per run, (m, m) Cholesky factor of the covariance of its data, walk and noise, in units of s²."""
        found = []
        for run in self.runs:
            seen = run.responses[self.parameter] @ _square_root(run.middles_s, self.correlation_s)
            covariance = np.eye(run.residual.size) + self.ratio * (seen @ seen.T)
            found.append(np.asarray(np.linalg.cholesky(covariance), dtype=np.float64))
        return tuple(found)

    @cached_property
    def innovations(self) -> tuple[Floats, ...]:
        """Per run, (m,) what each sample adds to those before it; white with variance 1 if the model is right."""
        found = []
        for root, rest in zip(self.roots, self.walked, strict=True):
            found.append(np.asarray(solve_triangular(root, rest, lower=True) / np.sqrt(self.s2)))
        return tuple(found)

    @cached_property
    def whiteness(self) -> tuple[float, float]:
        """Ljung–Box p of the innovations, and the sum of their squared correlations: the share that is predictable."""
        norm = sum(float(e @ e) for e in self.innovations)
        lags = np.arange(1, LAGS + 1)
        rho = np.array([sum(float(e[lag:] @ e[:-lag]) for e in self.innovations) for lag in lags]) / norm
        size = sum(e.size for e in self.innovations)
        q = size * (size + 2.0) * float(np.sum(rho**2 / (size - lags)))
        return float(chi2.sf(q, LAGS)), float(np.sum(rho**2))


@dataclass(frozen=True)
class _Moments:
    """Inner products of one run: of the responses (k, k), of them with slopes and residual (k, f + 1), of these."""

    middles_s: Floats
    responses: Floats
    seen: Floats
    total: Floats
    size: int

    @classmethod
    def of(cls, run: WalkRun, parameter: WalkingParameter) -> "_Moments":
        """Of a run and the responses to one parameter."""
        responses, data = run.responses[parameter], np.column_stack([run.slopes, run.residual])
        return cls(run.middles_s, responses.T @ responses, responses.T @ data, data.T @ data, run.residual.size)


@dataclass(frozen=True)
class _Spectrum:
    """One run at one correlation time, its levels rotated until the data see each of them by itself.

    information : (k,) on each of them; back : (k, k) from them to the levels; seen : (k, f + 1) slopes and residual as
    they see them; total : (f + 1, f + 1) inner products of slopes and residual; size : samples of the run.
    """

    information: Floats
    back: Floats
    seen: Floats
    total: Floats
    size: int


def smooth(
    runs: Sequence[WalkRun], parameters: Sequence[WalkingParameter]
) -> tuple[Smoothed, dict[WalkingParameter, float]]:
    """The likeliest of the walks of the parameters, and by how much ln likelihood each of them falls short of it.

    The noise of the sensor is autoregressive. It is estimated from what the likeliest walk leaves, as else it would
    swallow the walk. Parameters are compared on longer intervals, at which their walks cost little.
    """
    coarse = [_coarser(run) for run in runs]
    white = coarse
    for _ in range(ROUNDS):
        first = _ranked(_orthonormal(white), parameters, (USUAL_S,))[0]
        white = _whitened(coarse, coarse, first)
    ranked = _ranked(_orthonormal(white), parameters, CORRELATION_S)
    chosen = ranked[0].parameter
    fine = _likeliest(_orthonormal(_whitened(runs, coarse, ranked[0])), chosen, (USUAL_S,))
    best = _likeliest(_orthonormal(_whitened(runs, runs, fine)), chosen, FINE_S)
    return best, {s.parameter: ranked[0].ln_gain - s.ln_gain for s in ranked}


def _coarser(run: WalkRun) -> WalkRun:
    """The run with COARSE intervals made one."""
    first = np.arange(0, run.edges_s.size - 1, COARSE)
    responses = {p: np.add.reduceat(r, first, axis=1) for p, r in run.responses.items()}
    return replace(run, edges_s=np.append(run.edges_s[first], run.edges_s[-1]), responses=responses)


def _ranked(
    runs: Sequence[WalkRun], parameters: Sequence[WalkingParameter], correlation_s: Sequence[float]
) -> list[Smoothed]:
    return sorted((_likeliest(runs, p, correlation_s) for p in parameters), key=lambda s: -s.ln_gain)


def _orthonormal(runs: Sequence[WalkRun]) -> list[WalkRun]:
    """The runs, their slopes orthonormal over all of them, without combinations that the data do not show."""
    slopes = np.vstack([run.slopes for run in runs])
    norm = np.sqrt(np.sum(slopes**2, axis=0))
    left, values, _ = np.linalg.svd(slopes / np.where(norm > 0.0, norm, 1.0), full_matrices=False)
    kept = left[:, values > SMALLEST * float(values[0])] if values.size else left
    return [replace(run, slopes=part) for run, part in zip(runs, _by_run(kept, runs), strict=True)]


def _by_run(stacked: Floats, runs: Sequence[WalkRun]) -> list[Floats]:
    """Rows (N, …) of all runs → those of each."""
    return list(np.split(stacked, np.cumsum([run.residual.size for run in runs])[:-1]))


def _whitened(runs: Sequence[WalkRun], walked: Sequence[WalkRun], found: Smoothed) -> list[WalkRun]:
    """``runs`` filtered until what the walk leaves of ``walked``, the runs on its intervals, is white of variance 1."""
    rest = np.concatenate(
        [run.residual - run.responses[found.parameter] @ p for run, p in zip(walked, found.levels, strict=True)]
    )
    basis = np.vstack([run.slopes for run in _orthonormal(runs)])
    parts = _by_run(rest - basis @ (basis.T @ rest), runs)
    coefficients, sigma = _noise([_covariance(*pair, found) for pair in zip(walked, parts, found.factors, strict=True)])
    taps, skip = np.concatenate([[1.0], -coefficients]), coefficients.size

    def filtered(values: Floats) -> Floats:
        return np.asarray(lfilter(taps, np.ones(1), values, axis=0)[skip:] / sigma)

    return [
        replace(
            run,
            time_s=run.time_s[skip:],
            residual=filtered(run.residual),
            slopes=filtered(run.slopes),
            responses={p: filtered(r) for p, r in run.responses.items()},
        )
        for run in runs
    ]


def _covariance(run: WalkRun, rest: Floats, factor: Floats, found: Smoothed) -> tuple[Floats, int]:
    """Sums of lagged products (LONGEST + 1,) of the noise of a run, and how many samples it has.

    What the walk leaves has lost what the walk took of the noise: on average the covariance of the smoothed walk, which
    is added.
    """
    spread = run.responses[found.parameter] @ factor
    sums = [
        float(rest[lag:] @ rest[: rest.size - lag]) + float(np.sum(spread[lag:] * spread[: rest.size - lag]))
        for lag in range(LONGEST + 1)
    ]
    return np.array(sums), rest.size


def _noise(covariances: Sequence[tuple[Floats, int]]) -> tuple[Floats, float]:
    """Autoregressive coefficients of the noise and the standard deviation of its innovations (Yule and Walker)."""
    total = sum(size for _, size in covariances)
    covariance = np.sum([sums for sums, _ in covariances], axis=0) / total
    found, least = (np.empty(0), 1.0), np.inf
    for order in range(LONGEST + 1):
        phi = solve_toeplitz(covariance[:order], covariance[1 : order + 1]) if order else np.empty(0)
        innovation = float(covariance[0] - phi @ covariance[1 : order + 1])
        criterion = total * np.log(max(innovation, 1e-300)) + order * np.log(total)
        if criterion < least:
            least, found = criterion, (np.asarray(phi), float(np.sqrt(max(innovation, 1e-300))))
    return found


def _likeliest(runs: Sequence[WalkRun], parameter: WalkingParameter, correlation_s: Sequence[float]) -> Smoothed:
    """The walk of one parameter in whitened runs, over some correlation times."""
    moments = [_Moments.of(run, parameter) for run in runs]
    tried = []
    for tau in correlation_s:
        spectra = [_spectrum(m, tau) for m in moments]
        ratio, ln_likelihood = _best_ratio(spectra)
        tried.append((ln_likelihood, tau, ratio, spectra))
    ln_likelihood, tau, ratio, spectra = max(tried, key=lambda t: t[0])
    gain = max(0.0, ln_likelihood - _ln_likelihood(spectra, 0.0))
    return _smoothed(runs, parameter, spectra, tau, ratio, gain)


def _best_ratio(spectra: Sequence[_Spectrum]) -> tuple[float, float]:
    """σ²/s² of the highest likelihood, and that."""
    top = max(float(s.information.max()) for s in spectra)

    def loss(power: float) -> float:
        return -_ln_likelihood(spectra, 10.0**power / top)

    powers = np.linspace(*POWERS, 12)
    first = float(powers[int(np.argmin([loss(float(x)) for x in powers]))])
    found = minimize_scalar(loss, bounds=(first - 1.0, first + 1.0), method="bounded", options={"xatol": 0.02})
    return 10.0 ** float(found.x) / top, -float(found.fun)


def _square_root(middles_s: Floats, correlation_s: float) -> Floats:
    """(k, k) lower triangular root of C at evenly spaced times."""
    k = middles_s.size
    a = float(np.exp(-(middles_s[1] - middles_s[0]) / correlation_s)) if k > 1 else 0.0
    lag = np.subtract.outer(np.arange(k), np.arange(k))
    scale = np.where(np.arange(k) == 0, 1.0, np.sqrt(1.0 - a * a))
    return np.asarray(np.where(lag >= 0, a ** np.maximum(lag, 0), 0.0) * scale)


def _spectrum(moments: _Moments, correlation_s: float) -> _Spectrum:
    root = _square_root(moments.middles_s, correlation_s)
    values, vectors = np.linalg.eigh(root.T @ moments.responses @ root)
    back = root @ vectors
    return _Spectrum(np.maximum(values, 0.0), back, back.T @ moments.seen, moments.total, moments.size)


def _inner(spectra: Sequence[_Spectrum], ratio: float) -> Floats:
    """(f + 1, f + 1) inner products of slopes and residual, weighted by the inverse covariance of the data."""
    parts = [s.total - s.seen.T @ (s.seen * (ratio / (1.0 + ratio * s.information))[:, None]) for s in spectra]
    return np.asarray(np.sum(parts, axis=0))


def _shift(spectra: Sequence[_Spectrum], ratio: float) -> tuple[Floats, float, float]:
    """Free parameters (f,) at a ratio, the squared error weighted by the covariance of the data, and ln |JᵀS⁻¹J|."""
    inner = _inner(spectra, ratio)
    values, vectors = np.linalg.eigh(inner[:-1, :-1])
    values = np.maximum(values, SMALLEST)
    shift = vectors @ ((vectors.T @ inner[:-1, -1]) / values)
    return shift, max(float(inner[-1, -1] - inner[:-1, -1] @ shift), 1e-300), float(np.sum(np.log(values)))


def _ln_likelihood(spectra: Sequence[_Spectrum], ratio: float) -> float:
    """The restricted one, but for a constant; s² at its best value."""
    shift, error, ln_det = _shift(spectra, ratio)
    size = sum(s.size for s in spectra) - shift.size
    widths = sum(float(np.sum(np.log1p(ratio * s.information))) for s in spectra)
    return float(-0.5 * (size * np.log(error) + widths + ln_det))


def _smoothed(
    runs: Sequence[WalkRun],
    parameter: WalkingParameter,
    spectra: Sequence[_Spectrum],
    correlation_s: float,
    ratio: float,
    ln_gain: float,
) -> Smoothed:
    shift, error, _ = _shift(spectra, ratio)
    alone = _shift(spectra, 0.0)[0]
    s2 = error / (sum(s.size for s in spectra) - shift.size)
    levels, factors = [], []
    for s in spectra:
        spread = ratio / (1.0 + ratio * s.information)
        levels.append(s.back @ (spread * (s.seen[:, -1] - s.seen[:, :-1] @ shift)))
        factors.append(s.back * np.sqrt(s2 * spread))
    return Smoothed(
        parameter,
        tuple(runs),
        tuple(levels),
        tuple(factors),
        ln_gain,
        correlation_s,
        ratio,
        s2,
        tuple(run.residual - run.slopes @ alone for run in runs),
        tuple(
            run.residual - run.slopes @ shift - run.responses[parameter] @ p
            for run, p in zip(runs, levels, strict=True)
        ),
    )


def still_walks(walk: Smoothed, curves: Sequence[Floats]) -> float:
    """Share of the variance of the walk that is left beside a curve that all runs share.

    A path that is a function of the covariate leaves nothing to walk, one that is not leaves it all. Two paths that
    drift look alike by chance, so a curve has to explain the increments, and has to do it in all runs at once.

    Parameters
    ----------
    walk : at its maximum likelihood.
    curves : per run, (k, c) the basis of the curve in each interval. Its coefficients have a normal prior whose
        variance, like that of the walk, is that of the highest likelihood.
    """
    free = walk.runs[0].slopes.shape[1]
    beside = [
        replace(run, slopes=np.hstack([run.slopes, run.responses[walk.parameter] @ basis]))
        for run, basis in zip(walk.runs, curves, strict=True)
    ]
    spectra = [_spectrum(_Moments.of(run, walk.parameter), walk.correlation_s) for run in beside]
    usual = float(np.mean(np.concatenate(walk.levels) ** 2)) / walk.s2
    best = (-np.inf, 0.0)
    for power in REMAINING:
        ratio = walk.ratio * 10.0**power
        inner = _inner(spectra, ratio)
        widths = sum(float(np.sum(np.log1p(ratio * s.information))) for s in spectra)
        for variance in (0.01 * usual, 0.1 * usual, usual, 10.0 * usual):
            precision = np.concatenate([np.zeros(free), np.full(inner.shape[0] - free - 1, 1.0 / variance)])
            root = np.linalg.cholesky(inner[:-1, :-1] + np.diag(precision + SMALLEST))
            seen = solve_triangular(root, inner[:-1, -1], lower=True)
            s2 = (inner[-1, -1] - float(seen @ seen)) / (sum(s.size for s in spectra) - free)
            ln_det = 2.0 * float(np.sum(np.log(np.diag(root)))) + (precision.size - free) * np.log(variance)
            size = sum(s.size for s in spectra) - free
            best = max(best, (-0.5 * (size * np.log(s2) + widths + ln_det), ratio * s2))
    return float(min(1.0, best[1] / (walk.ratio * walk.s2)))
