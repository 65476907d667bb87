# SPDX-License-Identifier: Apache-2.0
"""Outliers: single readings far away from their neighbours.

Statistic: a reading of the residual less the median of the seven around it, over the robust spread of that difference.
What lasts longer than three readings is no outlier: a misfit is smooth, and a step stays.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.stats import norm

from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, energy
from lce_analysis.signatures.signature import Picture, Signature, amount

Floats = NDArray[np.float64]

AROUND: Final = 7
"""Samples of the median."""
MAD_OF_NORMAL: Final = 0.6745


def outliers(series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()) -> Signature | None:
    """Single readings of one sensor that lie far out; None if there are too few.

    Parameters
    ----------
    series : of one sensor, all runs.
    options : ``outlier_size`` and ``fewest_outliers``.
    """
    found = [far_out(s, options.outlier_size) for s in series]
    count = sum(int(out.sum()) for out in found)
    if count < options.fewest_outliers:
        return None
    samples = sum(s.time_s.size for s in series)
    expected = samples * 2.0 * float(norm.sf(options.outlier_size))
    channel = series[0].channel
    sizes = np.concatenate([np.abs(s.residual[out]) for s, out in zip(series, found, strict=True)])
    lost = sum(float(np.sum((s.residual[out] / s.noise) ** 2)) for s, out in zip(series, found, strict=True))
    share = lost / max(energy(series), 1e-300)
    if share < options.least_share:
        return None
    worst = int(np.argmax([out.sum() for out in found]))
    shown, out = series[worst], found[worst]
    return Signature(
        name="outliers",
        channel=channel,
        value=float(count),
        unit="1",
        covariate=None,
        p_value=min(math.exp(min(count * math.log(max(expected, 1e-300)), 0.0)), 1.0),
        share=min(share, 1.0),
        words=f"{count} single readings of the {channel.name} ({count / samples:.2g} of all) lie far out, "
        f"by {amount(channel, float(np.median(sizes)))} in the median",
        advice="look for dropped frames, reflections or loose contacts, and leave these readings out",
        picture=Picture(
            f"Residual with its outliers, {shown.run}",
            "time",
            "s",
            shown.time_s,
            "residual",
            {"residual": shown.residual},
            {"outlier": np.where(out, shown.residual, np.nan)},
        ),
    )


def _away(values: Floats) -> Floats:
    """Distance (n,) of values (n,) from the median around them."""
    return np.asarray(np.abs(values - median_filter(values, size=AROUND, mode="nearest")))


def far_out(series: ResidualSeries, size: float) -> NDArray[np.bool_]:
    """Which readings (n,) are outliers, by so many robust standard deviations; at most three in a row."""
    residual = series.residual
    if residual.size < 4 * AROUND:
        return np.zeros(residual.size, dtype=bool)
    # A jump that the model makes a sample early or late leaves the readings where they were.
    away = np.minimum(_away(residual), 2.0 * _away(series.measured))
    moving = away[away > 0.0]
    spread = max(float(np.median(moving)) / MAD_OF_NORMAL if moving.size else 0.0, series.noise)
    return np.asarray((away > size * spread) & series.counted)
