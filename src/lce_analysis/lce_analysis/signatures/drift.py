# SPDX-License-Identifier: Apache-2.0
"""A drift: the residual grows with the time since the beginning of a run.

Statistic: the share of the residual's energy that one slope over time, from all other runs, predicts in the runs left
out, beyond what a constant does. It must be most of what a curve over any other covariate predicts: a slow misfit of
the physics grows with time, too.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from lce_analysis.signatures.follows import THINNED, Member, beyond_level, chance, left_out
from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, misfit
from lce_analysis.signatures.signature import Picture, Signature, amount

MOST: Final = 0.8
"""Part of what the best curve predicts that a straight line over time must reach."""


def drift(
    series: Sequence[ResidualSeries], followed: float, options: SignatureOptions = SignatureOptions()
) -> Signature | None:
    """How fast the residual of one sensor grows with time; None if it does not.

    Parameters
    ----------
    series : of one sensor, all runs.
    followed : share that the best curve over a covariate predicts in runs left out, 0 if none was found.
    options : ``drifting``, ``explained`` and ``false_alarm``.
    """
    if len(series) < 2 or misfit(series) <= options.explained:
        return None
    line = left_out([_member(s) for s in series])
    share = beyond_level(series, line.share)
    if share < max(options.drifting, MOST * followed):
        return None
    p_value = chance([_member(s.thinned(THINNED)) for s in series], line.share, options.shifts)
    if p_value > options.false_alarm:
        return None
    channel = series[0].channel
    noise = float(np.median([s.noise for s in series]))
    rate = float(line.coefficients[1]) * noise
    shown = max(series, key=lambda s: float(np.ptp(s.time_s)))
    elapsed = shown.time_s - shown.time_s[0]
    return Signature(
        name="drift",
        channel=channel,
        value=rate,
        unit=f"{channel.unit}/s",
        covariate="time",
        p_value=p_value,
        share=share,
        words=f"the residual of the {channel.name} grows with time, by {amount(channel, 60.0 * rate)} in a minute "
        f"({share:.0%} of it in runs left out)",
        advice="record a rest before and after the run: a drift of the sensor goes on there",
        picture=Picture(
            f"Residual over time, {shown.run}",
            "time",
            "s",
            shown.time_s,
            "residual",
            {"residual": shown.residual, "drift": noise * line.coefficients[0] + rate * elapsed},
            {},
        ),
        repeats=True,
    )


def _member(series: ResidualSeries) -> Member:
    basis = np.column_stack([np.ones(series.time_s.size), series.time_s - series.time_s[0]])
    return np.where(series.counted[:, None], basis, 0.0), series.residual / series.noise
