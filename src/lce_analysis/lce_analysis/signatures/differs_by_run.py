# SPDX-License-Identifier: Apache-2.0
"""Runs that differ: each wants a level and a scale of its own, which no common curve gives.

Statistic: the share of the residual's energy, beyond common curves over temperature (branch by branch), rate and power,
that a level and a scale for each run predict in fifths of the runs, left out in turn. The p-value is that of an F
distribution of as many independent blocks as the runs have.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from lce_analysis.covariates import hats, quantile_knots
from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, misfit
from lce_analysis.signatures.signature import Picture, Signature, amount

Floats = NDArray[np.float64]

THINNED: Final = 1000
"""Samples of a run that are enough."""
PARTS: Final = 5
"""Parts of every run that are left out in turn."""
COMMON: Final = ("temperature", "rate", "power")
"""Covariates over which all runs share a curve."""


def differs_by_run(
    series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()
) -> Signature | None:
    """How much the runs of one sensor differ beyond what they have in common; None if they do not.

    Parameters
    ----------
    series : of one sensor, all runs.
    options : ``differs``, ``knots``, ``block_s``, ``explained`` and ``false_alarm``.
    """
    if len(series) < 3 or misfit(series) <= options.explained:
        return None
    thin = [s.thinned(THINNED) for s in series]
    residual = np.concatenate([s.residual / s.noise for s in thin])
    common = _common(thin, options.knots)
    own = _own(thin)
    fifths = np.concatenate([np.arange(s.time_s.size) * PARTS // s.time_s.size for s in thin])
    without, with_own = (_left_out(basis, residual, fifths) for basis in (common, np.column_stack([common, own])))
    share = 1.0 - with_own / max(without, 1e-300)
    blocks = sum(max(float(np.ptp(s.time_s)) / options.block_s, 1.0) for s in series)
    freedom = own.shape[1] - 2
    left = max(2.0 * blocks - own.shape[1], 2.0)
    p_value = float(f_distribution.sf(share / freedom / max((1.0 - share) / left, 1e-300), freedom, left))
    if share < options.differs or p_value > options.false_alarm:
        return None
    channel = series[0].channel
    means = np.array([float(np.mean(s.residual[s.counted])) for s in series])
    spread = float(np.std(means))
    return Signature(
        name="differs_by_run",
        channel=channel,
        value=spread,
        unit=channel.unit,
        covariate=None,
        p_value=p_value,
        share=share,
        words=f"the residual of the {channel.name} differs from run to run, its mean by {amount(channel, spread)} rms: "
        f"a level and a scale for each run take {share:.0%} of what no common curve takes",
        advice="note what differed: day, room, load; `lce fit --varies` gives a parameter a value for each run",
        picture=Picture(
            "Mean residual of each run",
            "run",
            "1",
            np.arange(1.0, len(series) + 1.0),
            "residual",
            {},
            {"mean residual": means},
        ),
        repeats=False,
    )


def _common(series: Sequence[ResidualSeries], knots: int) -> Floats:
    """Hats (n, k) over what all runs know, one after the other."""
    columns = [np.ones((sum(s.time_s.size for s in series), 1))]
    for name in (c for c in COMMON if all(c in s.covariates for s in series)):
        x = np.concatenate([s.covariates[name] for s in series])
        branch = np.concatenate([s.covariates.get("branch", np.ones(s.time_s.size)) for s in series])
        for side in (1.0, -1.0) if name == "temperature" else (0.0,):
            part = np.where(branch == side, x, np.nan) if side else x
            columns.append(hats(part, quantile_knots(part, knots)))
    return np.column_stack(columns)


def _own(series: Sequence[ResidualSeries]) -> Floats:
    """A level and a scale for each run (n, 2 runs): the scale is over the modelled signal."""
    total, begin = sum(s.time_s.size for s in series), 0
    basis = np.zeros((total, 2 * len(series)))
    for i, s in enumerate(series):
        end = begin + s.time_s.size
        basis[begin:end, 2 * i] = s.counted
        basis[begin:end, 2 * i + 1] = np.where(s.counted, s.modelled - s.modelled.mean(), 0.0) / max(
            float(np.std(s.modelled)), 1e-300
        )
        begin = end
    return basis


def _left_out(basis: Floats, residual: Floats, part: NDArray[np.intp]) -> float:
    """Energy of what a regression does not predict in each part of every run, left out in turn."""
    q = basis / np.maximum(np.linalg.norm(basis, axis=0), 1e-300)
    total = 0.0
    for k in range(PARTS):
        out = part == k
        gram = q[~out].T @ q[~out] + 1e-4 * np.eye(q.shape[1])
        rest = residual[out] - q[out] @ np.linalg.solve(gram, q[~out].T @ residual[~out])
        total += float(rest @ rest)
    return total
