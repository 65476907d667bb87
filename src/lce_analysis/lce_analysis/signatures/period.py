# SPDX-License-Identifier: Apache-2.0
"""A period: a line in the spectrum of the residual that stands out of its smooth background, run after run.

Statistic: at each frequency the sum over the runs of power / background, each run capped, so that several must agree.
The background is a smooth spectrum, so neither coloured noise nor smooth misfit makes a line. A run in whose laser
power the same line stands does not count: there any misfit repeats with the protocol.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import gamma

from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries
from lce_analysis.signatures.signature import Picture, Signature, amount
from lce_analysis.signatures.spectrum import FINE, background, spectrum

Floats = NDArray[np.float64]

MOST = 500
"""Samples of one run that a spectrum is taken of; more are averaged in blocks."""


@dataclass(frozen=True)
class _Ratios:
    """Power over background (m,) of one run, NaN where it does not count, and the power itself."""

    ratio: Floats
    power: Floats


def period(series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()) -> Signature | None:
    """The strongest period in the residual of one sensor; None if there is none.

    Parameters
    ----------
    series : of one sensor, all runs.
    options : ``cycles``, ``line``, ``input_line``, ``line_chance`` and ``least_share``.
    """
    long_enough = [s for s in series if s.counted.sum() > 64]
    if not long_enough:
        return None
    longest = max(float(np.ptp(s.time_s)) for s in long_enough)
    step = max(max(s.step_s, float(np.ptp(s.time_s)) / MOST) for s in long_enough)
    low, high = options.cycles / longest, 0.25 / step
    if high <= 2.0 * low:
        return None
    frequencies = np.arange(low, high, 1.0 / (FINE * longest))
    runs = [_ratios(s, frequencies, options) for s in long_enough]
    counted = np.array([np.isfinite(run.ratio) for run in runs])
    count = counted.sum(axis=0)
    cap = options.line * np.maximum(1.0, 3.0 / np.maximum(count, 1))
    total = np.sum([np.minimum(np.nan_to_num(run.ratio), cap) for run in runs], axis=0)
    enough = count >= min(3, len(long_enough))
    chance = np.where(enough, gamma.sf(total, np.maximum(count, 1)), 1.0)
    independent = (high - low) * longest
    best = _highest(runs, frequencies, int(np.argmin(chance)), 2.0 / longest)
    p_value = float(min(chance.min() * independent, 1.0))
    squares = np.array([np.where(run, one.power, np.nan)[best] for run, one in zip(counted, runs, strict=True)])
    here = [s for s, run in zip(long_enough, counted, strict=True) if run[best]]
    energy = sum(float(np.mean(s.residual**2)) for s in here)
    share = float(0.5 * np.nansum(squares) / energy) if energy > 0.0 else 0.0
    if p_value > options.line_chance or share < options.least_share:
        return None
    mean = np.nansum([run.ratio for run in runs], axis=0) / np.maximum(count, 1)
    channel, value = series[0].channel, float(1.0 / frequencies[best])
    swing = float(np.sqrt(np.nanmean(squares)))
    return Signature(
        name="period",
        channel=channel,
        value=value,
        unit="s",
        covariate=None,
        p_value=p_value,
        share=min(share, 1.0),
        words=f"the {channel.name} swings with a period of {value:.3g} s, by ±{amount(channel, swing)}, "
        f"in {len(here)} of {len(series)} runs by a clock of its own",
        advice="look for what has this period: a fan, an air conditioner, a pump, the supply of the laser",
        picture=Picture(
            f"Spectrum of the residual over its background, a line at {value:.3g} s",
            "frequency",
            "Hz",
            frequencies,
            "spectrum",
            {"mean of the runs": mean},
            {"the line": np.where(np.arange(frequencies.size) == best, mean, np.nan)},
        ),
    )


def _highest(runs: Sequence[_Ratios], frequencies: Floats, place: int, width: float) -> int:
    """Where the line near a place is highest, no run capped: the cap flattens its top, and a background bends it."""
    near = np.flatnonzero(np.abs(frequencies - frequencies[place]) <= width)
    levels = [np.nan_to_num(run.ratio[place] / max(run.power[place], 1e-300)) for run in runs]
    total = np.sum([run.power[near] * level for run, level in zip(runs, levels, strict=True)], axis=0)
    return int(near[np.argmax(total)])


def _ratios(series: ResidualSeries, frequencies: Floats, options: SignatureOptions) -> _Ratios:
    time, residual, power_w = averaged(series)
    duration = float(time[-1] - time[0])
    power = spectrum(time, residual, frequencies)
    ratio = power / background(frequencies, power, duration)
    known = frequencies >= options.cycles / duration
    if power_w is not None and np.ptp(power_w) > 0.0:
        driven = spectrum(time, power_w, frequencies)
        known &= driven < options.input_line * background(frequencies, driven, duration)
    return _Ratios(np.where(known, ratio, np.nan), power)


def averaged(series: ResidualSeries) -> tuple[Floats, Floats, Floats | None]:
    """Times, residual and laser power in blocks, at most :data:`MOST`; samples that do not count are left out."""
    block = -(-series.time_s.size // MOST)
    index = np.arange(series.time_s.size)[series.counted] // block
    count = np.bincount(index)
    used = count > 0

    def mean(values: Floats) -> Floats:
        return np.asarray(np.bincount(index, weights=values[series.counted])[used] / count[used])

    power = series.covariates.get("power")
    return mean(series.time_s), mean(series.residual), None if power is None else mean(power)
