# SPDX-License-Identifier: Apache-2.0
"""What a residual follows: a curve over a covariate that is fitted to all runs but one and predicts that one.

Statistic: the share of the residual's energy that such curves predict in the runs left out, beyond a constant. Noise
does not repeat itself. The p-value comes from shifting the residual against the covariate in time, by chance, in every
run: that keeps the colour of both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.covariates import COVARIATES, hats, quantile_knots
from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, misfit
from lce_analysis.signatures.signature import DISCOVER, Picture, Signature

Floats = NDArray[np.float64]
Member = tuple[Floats, Floats]
"""Basis (n, k) and residual (n,) of one run."""

NEAR: Final = 0.8
"""Covariates that predict this part of what the best one does are named beside it."""
THINNED: Final = 1500
"""Samples of a run that the random shifts take."""
BRANCHES: Final = {1.0: "while heating", -1.0: "while cooling"}


@dataclass(frozen=True)
class Curve:
    """A residual over one covariate.

    share : of the residual's energy that it predicts in runs left out; 0 for a single run.
    coefficients : (k,) from all runs.
    """

    share: float
    coefficients: Floats


def left_out(members: Sequence[Member]) -> Curve:
    """Linear regression of the residual of all runs, judged by leaving out one run after the other."""
    grams, moments = (np.array(x) for x in zip(*((b.T @ b, b.T @ r) for b, r in members), strict=True))
    gram, moment = grams.sum(axis=0), moments.sum(axis=0)
    before = after = 0.0
    for (basis, residual), g, c in zip(members, grams, moments, strict=True):
        rest = residual - basis @ _solve(gram - g, moment - c)
        before += float(residual @ residual)
        after += float(rest @ rest)
    share = 1.0 - after / before if before > 0.0 and len(members) > 1 else 0.0
    return Curve(share, _solve(gram, moment))


def beyond_level(series: Sequence[ResidualSeries], share: float) -> float:
    """The share that a curve predicts of what the mean of the other runs does not."""
    level = left_out([(s.counted.astype(np.float64)[:, None], s.residual / s.noise) for s in series]).share
    return 1.0 - (1.0 - share) / (1.0 - min(max(level, 0.0), 0.999))


def _solve(gram: Floats, moment: Floats) -> Floats:
    # A knot that the other runs never come near has no say.
    ridge = 1e-6 * float(np.trace(gram)) / max(gram.shape[0], 1) + 1e-300
    return np.asarray(np.linalg.solve(gram + ridge * np.eye(gram.shape[0]), moment))


def chance(members: Sequence[Member], share: float, shifts: int, seed: int = 0) -> float:
    """Share of random shifts in time of the residuals, run by run, that predict as much."""
    rng = np.random.default_rng(seed)
    grams, moments, energies = [], [], []
    for basis, residual in members:
        n = residual.size
        spectrum = np.fft.rfft(basis, axis=0).conj() * np.fft.rfft(residual)[:, None]
        every = np.fft.irfft(spectrum, n=n, axis=0)
        taken = rng.integers(n // 10, max(n - n // 10, n // 10 + 1), shifts)
        grams.append(basis.T @ basis)
        moments.append(every[taken])
        energies.append(float(residual @ residual))
    gram, moment = np.sum(grams, axis=0), np.sum(moments, axis=0)
    fall = np.zeros(shifts)
    for g, c in zip(grams, moments, strict=True):
        rest = gram - g
        ridge = (1e-6 * np.trace(rest) / rest.shape[0] + 1e-300) * np.eye(rest.shape[0])
        curve = np.linalg.solve(rest + ridge, (moment - c).T).T
        fall += 2.0 * np.sum(curve * c, axis=1) - np.sum((curve @ g) * curve, axis=1)
    return float((1 + np.count_nonzero(fall / max(sum(energies), 1e-300) >= share)) / (1 + shifts))


@dataclass(frozen=True)
class _Found:
    covariate: str
    branch: float | None
    knots: Floats
    curve: Curve


def follows(series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()) -> Signature | None:
    """The covariate that the residual of one sensor follows most; None if it follows none.

    Parameters
    ----------
    series : of one sensor, all runs; a single run has nothing to be left out.
    options : ``structured``, ``knots``, ``shifts``, ``explained`` and ``false_alarm``.
    """
    if len(series) < 2 or misfit(series) <= options.explained:
        return None
    found = sorted(_all(series, options), key=lambda one: -one.curve.share)
    if not found or (share := beyond_level(series, found[0].curve.share)) < options.structured:
        return None
    best, *others = found
    p_value = chance(_members([s.thinned(THINNED) for s in series], best), best.curve.share, options.shifts)
    if p_value > options.false_alarm:
        return None
    near = [one for one in others if beyond_level(series, one.curve.share) >= NEAR * share]
    return _told(series, best, near, share, p_value)


def _all(series: Sequence[ResidualSeries], options: SignatureOptions) -> list[_Found]:
    """Every covariate that all runs know, the temperature branch by branch."""
    found = []
    for name in COVARIATES:
        if all(name in s.covariates for s in series):
            for branch in BRANCHES if name == "temperature" else (None,):
                knots = quantile_knots(np.concatenate([_covariate(s, name, branch) for s in series]), options.knots)
                if knots.size > 1:
                    one = _Found(name, branch, knots, Curve(0.0, knots))
                    found.append(_Found(name, branch, knots, left_out(_members(series, one))))
    return found


def _covariate(series: ResidualSeries, name: str, branch: float | None) -> Floats:
    x = series.covariates[name]
    return x if branch is None else np.where(series.covariates["branch"] == branch, x, np.nan)


def _members(series: Sequence[ResidualSeries], one: _Found) -> list[Member]:
    return [(hats(_covariate(s, one.covariate, one.branch), one.knots), s.residual / s.noise) for s in series]


def _words(one: _Found) -> str:
    on = "" if one.branch is None else f" {BRANCHES[one.branch]}"
    return f"{COVARIATES[one.covariate].words}{on}"


def _told(
    series: Sequence[ResidualSeries], best: _Found, near: Sequence[_Found], share: float, p_value: float
) -> Signature:
    channel = series[0].channel
    also = f" (nearly as well as {', '.join(_words(one) for one in near)})" if near else ""
    noise = float(np.median([s.noise for s in series]))
    return Signature(
        name="follows",
        channel=channel,
        value=share,
        unit="1",
        covariate=best.covariate,
        p_value=p_value,
        share=share,
        words=f"the residual of the {channel.name} follows the {_words(best)}{also}: {share:.0%} of it in runs left "
        "out",
        advice=DISCOVER,
        picture=Picture(
            f"Residual over the {_words(best)}",
            COVARIATES[best.covariate].words,
            COVARIATES[best.covariate].unit,
            best.knots,
            "residual",
            {"mean residual": best.curve.coefficients * noise},
            {},
        ),
        repeats=True,
    )
