# SPDX-License-Identifier: Apache-2.0
"""Noise that depends on the signal.

Statistic: the noise of short blocks from the third differences of the readings, in which signal and misfit vanish,
against the modelled signal there: rank correlation over all blocks, and the noise at one end of the range over that at
the other.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries
from lce_analysis.signatures.signature import Picture, Signature, amount

Floats = NDArray[np.float64]

BLOCK: Final = 40
"""Samples of a block."""
GAIN: Final = 0.6745 * 20.0**0.5
"""Median of |third difference| over the standard deviation of white noise."""
FEWEST: Final = 24
PARTS: Final = 8
"""Parts of the signal's range, of equally many blocks."""


def variance(series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()) -> Signature | None:
    """Noise of one sensor that grows or falls with its signal; None if it does not.

    Parameters
    ----------
    series : of one sensor, all runs.
    options : ``louder`` and ``false_alarm``.
    """
    blocks = [_blocks(s) for s in series]
    signal, noise = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    if signal.size < FEWEST or np.ptp(signal) == 0.0:
        return None
    test = spearmanr(signal, noise)
    order = np.array_split(np.argsort(signal), PARTS)
    level = np.array([np.median(signal[i]) for i in order])
    spread = np.array([np.median(noise[i]) for i in order])
    low, high = float(np.mean(spread[:2])), float(np.mean(spread[-2:]))
    ratio = max(high, low) / max(min(high, low), 1e-3 * max(high, low), 1e-300)
    p_value = float(test.pvalue)
    if p_value > 1e-2 * options.false_alarm or ratio < options.louder or abs(float(test.statistic)) < 0.3:
        return None
    channel = series[0].channel
    grows = "grows" if high > low else "falls"
    return Signature(
        name="variance",
        channel=channel,
        value=ratio,
        unit="1",
        covariate=None,
        p_value=p_value,
        share=0.0,
        words=f"the noise of the {channel.name} {grows} with its signal, from {amount(channel, low)} to "
        f"{amount(channel, high)}",
        advice="give the sensor's noise as it depends on the signal less weight there, or look at its optics and range",
        picture=Picture(
            f"Noise of the {channel.name} over its signal",
            channel.name,
            channel.unit,
            level,
            "noise",
            {"noise": spread},
            {},
        ),
    )


def _blocks(series: ResidualSeries) -> tuple[Floats, Floats]:
    """Modelled signal and noise (blocks,) in short blocks; blocks in which the readings stand still are left out."""
    count = (series.measured.size - 3) // BLOCK
    third = np.abs(np.diff(series.measured - series.modelled, 3))[: count * BLOCK].reshape(count, BLOCK)
    signal = series.modelled[: count * BLOCK].reshape(count, BLOCK).mean(axis=1)
    counts = series.counted[: count * BLOCK].reshape(count, BLOCK).all(axis=1)
    noise = np.median(third, axis=1) / GAIN
    keep = counts & (noise > 0.0)
    return signal[keep], noise[keep]
