# SPDX-License-Identifier: Apache-2.0
"""Steps: the residual jumps from one reading to the next and stays there.

Statistic: straight lines through the residual before and after each sample, how far apart they are there, over the
robust spread of this distance in the whole run. Coloured noise and smooth misfit enter the spread. A jump must happen
within two samples, and away from jumps of the laser power and turns of the temperature, where the error of any model is
largest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.signal import fftconvolve
from scipy.stats import norm

from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.outliers import AROUND, far_out
from lce_analysis.signatures.series import ResidualSeries, energy
from lce_analysis.signatures.signature import Picture, Signature, amount
from lce_data.channels import DISPLACEMENT, Channel

Floats = NDArray[np.float64]

MAD_OF_NORMAL: Final = 0.6745
QUICK: Final = 3
"""Samples before and after a jump that show whether it happens at once."""
AT_ONCE: Final = 0.6
"""Share of a jump that must happen at once."""
FEWEST: Final = 10
"""Samples on each side of a jump, at least."""
MANY: Final = 10
"""So many jumps are a staircase, as of a guide that sticks: between them the residual comes back."""


@dataclass(frozen=True)
class Jumps:
    """Jumps (k,) of one residual: which sample is the first behind each, how large [SI], and over its spread."""

    index: NDArray[np.intp]
    size: Floats
    score: Floats

    def above(self, score: float) -> "Jumps":
        """Those with a larger score."""
        keep = self.score > score
        return Jumps(self.index[keep], self.size[keep], self.score[keep])


def step(series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()) -> Signature | None:
    """Where the residual of one sensor jumps; None if it does not.

    Parameters
    ----------
    series : of one sensor, all runs.
    options : the fields that begin with ``step``, and ``turn_s``.
    """
    found = [jumps(s, options) for s in series]
    if sum(one.index.size for one in found) < MANY:
        found = [one.above(options.step_size) for one in found]
    count = sum(one.index.size for one in found)
    if count == 0:
        return None
    channel = series[0].channel
    sizes, scores = (np.concatenate([getattr(one, name) for one in found]) for name in ("size", "score"))
    run = int(np.argmax([one.score.max(initial=0.0) for one in found]))
    shown, own = series[run], found[run]
    largest = int(own.index[np.argmax(own.score)])
    value = float(sizes[np.argmax(scores)]) if count < MANY else float(np.median(np.abs(sizes)))
    share = min(_removed(series, found) / max(energy(series), 1e-300), 1.0)
    if share < options.least_share:
        return None
    many = count >= MANY
    samples = sum(s.time_s.size for s in series)
    where = f"at {shown.time_s[largest]:.4g} s of {shown.run}"
    words = (
        f"the {channel.name} jumps by {amount(channel, value)} {where}"
        if count == 1
        else f"the {channel.name} jumps {count} times, by {amount(channel, float(np.median(np.abs(sizes))))} in the "
        f"median, most clearly {where}"
    )
    return Signature(
        name="step",
        channel=channel,
        value=value,
        unit=channel.unit,
        covariate=None,
        p_value=min(float(2.0 * samples * norm.sf(scores.max())), 1.0),
        share=share,
        words=words,
        advice=_advice(channel, many),
        picture=Picture(
            f"Residual and its jumps, {shown.run}",
            "time",
            "s",
            shown.time_s,
            "residual",
            {"residual": shown.residual} | ({} if many else {"jumps": _staircase(shown.time_s.size, own)}),
            {"jump": _at(own.index, shown.residual)} if many else {},
        ),
    )


def _advice(channel: Channel, many: bool) -> str:
    if channel is not DISPLACEMENT:
        return "look for a knock or a new setting of the sensor"
    if many:
        return "look for friction: a guide or a beam that sticks and breaks away"
    return "look for a slip or a knock; `lce diagnose` tries `displacement_step` on single runs"


def _at(index: NDArray[np.intp], values: Floats) -> Floats:
    """Values (n,) at some samples, NaN at all others."""
    found = np.full(values.size, np.nan)
    found[index] = values[index]
    return found


def jumps(series: ResidualSeries, options: SignatureOptions) -> Jumps:
    """The jumps of one residual from ``many_step_size`` on, one for each run of neighbouring samples that show it."""
    nothing = Jumps(np.empty(0, dtype=np.intp), np.empty(0), np.empty(0))
    side = max(round(options.step_s / series.step_s), FEWEST)
    if series.time_s.size < 6 * side:
        return nothing
    residual = _without_outliers(series, options.outlier_size)
    apart = _apart(residual, side)
    spread = float(np.median(np.abs(apart[side:-side]))) / MAD_OF_NORMAL
    at_once = _apart_at_once(residual)
    size = np.abs(apart)
    large = size > max(options.many_step_size * spread, options.step_noise * series.noise, 1e-300)
    sharp = (np.sign(at_once) == np.sign(apart)) & (np.abs(at_once) > AT_ONCE * size)
    here = np.flatnonzero(large & sharp & _quiet(series, options.turn_s, side))
    if here.size == 0:
        return nothing
    groups = np.split(here, np.flatnonzero(np.diff(here) > side) + 1)
    index = np.array([g[np.argmax(size[g])] for g in groups])
    return Jumps(index, apart[index], size[index] / spread)


def _without_outliers(series: ResidualSeries, size: float) -> Floats:
    """The residual (n,), the median around it where a single reading lies far out: that is no step."""
    residual = series.residual
    return np.where(far_out(series, size), median_filter(residual, size=AROUND, mode="nearest"), residual)


def _apart(residual: Floats, side: int) -> Floats:
    """How far apart straight lines through ``side`` samples before and after each sample are there (n,)."""
    padded = np.pad(residual, side, mode="edge")
    return np.asarray(fftconvolve(padded, _kernel(side)[::-1], mode="valid"))[: residual.size]


@cache
def _kernel(side: int) -> Floats:
    """Weights (2 side,) of the samples before and after: the difference of two straight lines halfway between them."""
    t = np.arange(side) + 0.5
    line = np.linalg.pinv(np.column_stack([np.ones(side), t]))[0]
    return np.asarray(np.concatenate([-line[::-1], line]))


def _apart_at_once(residual: Floats) -> Floats:
    """Mean of the samples from each on, less that of the samples before it (n,)."""
    padded = np.pad(residual, QUICK, mode="edge")
    running = np.concatenate([[0.0], np.cumsum(padded)])
    n = residual.size
    after, before = (
        running[2 * QUICK : 2 * QUICK + n] - running[QUICK : QUICK + n],
        running[QUICK : QUICK + n] - running[:n],
    )
    return np.asarray((after - before) / QUICK)


def _quiet(series: ResidualSeries, turn_s: float, side: int) -> NDArray[np.bool_]:
    """Samples (n,) away from jumps of the power, turns of the temperature, jumps of the model and the run's ends."""
    quiet = np.array(series.counted)
    for at in series.time_s[series.turning | ~series.counted]:
        quiet[np.searchsorted(series.time_s, at - 0.1 * turn_s) : np.searchsorted(series.time_s, at + turn_s)] = False
    quiet[:side] = quiet[-side:] = False
    return quiet


def _staircase(size: int, found: Jumps) -> Floats:
    """The sum of the jumps (n,), around zero."""
    stairs = np.zeros(size)
    stairs[found.index] = found.size
    stairs = np.cumsum(stairs)
    return np.asarray(stairs - stairs.mean())


def _removed(series: Sequence[ResidualSeries], found: Sequence[Jumps]) -> float:
    """Energy of the jumps in the residuals, in units of the noise: of stairs that stay, or of a sawtooth of many."""
    sizes = np.concatenate([np.abs(own.size) for own in found])
    if sizes.size >= MANY:
        return float(sum(s.time_s.size / s.noise**2 for s in series) * np.median(sizes) ** 2 / 12.0)
    total = 0.0
    for s, own in zip(series, found, strict=True):
        if own.index.size:
            stairs = _staircase(s.time_s.size, own) / s.noise
            inside = float(stairs @ (s.residual / s.noise))
            total += max(inside, 0.0) ** 2 / float(stairs @ stairs)
    return total
