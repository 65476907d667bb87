# SPDX-License-Identifier: Apache-2.0
"""A clipped sensor: it ends at one value while the model goes on.

Statistic: at the end of its range the sensor scatters about one value by no more than its noise, the model passes that
value by many times the noise, and the flat parts begin with a kink that the model does not have. The peaks of a smooth
misfit are flat, too, but they have no kink and do not share one value.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from lce_analysis.signatures.options import SignatureOptions
from lce_analysis.signatures.series import ResidualSeries, energy
from lce_analysis.signatures.signature import Picture, Signature, reading
from lce_data.channels import TEMPERATURE, Channel
from lce_data.units import KELVIN

Floats = NDArray[np.float64]
Span = tuple[int, int]

SMOOTH: Final = 5
"""Samples over which readings are averaged to find the end of the range."""
SLOPE_S: Final = 1.0
"""Span [s] of the slopes before and behind a kink."""
GAP_S: Final = 0.2
"""Time [s] around a kink that belongs to neither side."""


@dataclass(frozen=True)
class _End:
    """An end of the range: its value, and the spans of samples of each series that lie on it."""

    value: float
    spans: list[list[Span]]


def clipped(series: Sequence[ResidualSeries], options: SignatureOptions = SignatureOptions()) -> Signature | None:
    """The value at which one sensor ends, at the top or at the bottom; None if it does not.

    Parameters
    ----------
    series : of one sensor, all runs.
    options : the fields that begin with ``clip``.
    """
    for sign, word in ((1.0, "above"), (-1.0, "below")):
        end = _end([_turned(s, sign) for s in series], options)
        told = None if end is None else _told(series, replace(end, value=sign * end.value), word)
        if told is not None and told.share >= options.least_share:
            return told
    return None


def _turned(series: ResidualSeries, sign: float) -> ResidualSeries:
    return replace(series, measured=sign * series.measured, modelled=sign * series.modelled)


def _end(series: Sequence[ResidualSeries], options: SignatureOptions) -> _End | None:
    """The upper end of the range."""
    noise = float(np.median([s.noise for s in series]))
    smooth = [uniform_filter1d(s.measured, SMOOTH, mode="nearest") for s in series]
    top = max(float(x.max()) for x in smooth)
    near = np.concatenate(
        [s.measured[x > top - 2.0 * options.clip_flat * noise] for s, x in zip(series, smooth, strict=True)]
    )
    value = float(np.median(near))
    spans = [_spans(x > value - options.clip_flat * noise, s) for s, x in zip(series, smooth, strict=True)]
    flat = _joined([s.measured for s in series], spans) - value
    above = _joined([s.modelled for s in series], spans) - value
    if flat.size < options.clip_samples:
        return None
    still = float(np.sqrt(np.mean(flat**2))) <= options.clip_flat * noise
    passed = np.sqrt(np.mean(np.maximum(above, 0.0) ** 2)) > options.clip_excess * noise and np.mean(above) > 0.0
    if not still or not passed:
        return None
    kinks = [k for s, own in zip(series, spans, strict=True) for span in own if (k := _kink(s, span)) is not None]
    broken = [measured > options.clip_kink and modelled < 0.5 * options.clip_kink for measured, modelled in kinks]
    return _End(value, spans) if kinks and np.mean(broken) >= 0.5 else None


def _spans(on: NDArray[np.bool_], series: ResidualSeries) -> list[Span]:
    """Where a series stays on its end for half a second or more."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(np.int8)))
    least = max(0.5 / series.step_s, 5.0)
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= least]


def _joined(values: Sequence[Floats], spans: Sequence[Sequence[Span]]) -> Floats:
    return np.concatenate([np.empty(0), *(x[a:b] for x, own in zip(values, spans, strict=True) for a, b in own)])


def _kink(series: ResidualSeries, span: Span) -> tuple[float, float] | None:
    """By how much of itself the slope falls where a flat part begins, of the readings and of the model.

    None if it begins at the edge of the run, if it is too short to tell, or if the readings hardly rose before.
    """
    begin = series.time_s[span[0]]
    before = (series.time_s < begin - GAP_S) & (series.time_s >= begin - GAP_S - SLOPE_S)
    behind = (series.time_s > begin + GAP_S) & (series.time_s <= begin + GAP_S + SLOPE_S)
    behind[span[1] :] = False
    if before.sum() < 5 or behind.sum() < 5:
        return None
    falls = []
    for x in (series.measured, series.modelled):
        rise, on = (float(np.polyfit(series.time_s[part], x[part], 1)[0]) for part in (before, behind))
        if rise * SLOPE_S < 3.0 * series.noise:
            return None
        falls.append((rise - on) / rise)
    return falls[0], falls[1]


def _remedy(channel: Channel, end: float, word: str) -> str:
    """The effect of the library that is the end of a sensor's range, which the camera has at the top only."""
    if channel is not TEMPERATURE:
        return f", or fit with `--effect {channel.name}_clip`"
    if word == "below" or end <= KELVIN:
        return ""
    return f", or fit with `--effect temperature_clip --set temperature_clip.inverse={1.0 / (end - KELVIN):.4g}`"


def _told(series: Sequence[ResidualSeries], end: _End, word: str) -> Signature:
    channel = series[0].channel
    lost = sum(
        float(np.sum((s.residual[a:b] / s.noise) ** 2))
        for s, own in zip(series, end.spans, strict=True)
        for a, b in own
    )
    share = min(lost / max(energy(series), 1e-300), 1.0)
    worst = int(np.argmax([sum(b - a for a, b in own) for own in end.spans]))
    shown = series[worst]
    count = sum(len(own) for own in end.spans)
    return Signature(
        name="clipped",
        channel=channel,
        value=channel.recorded.from_si(end.value),
        unit=channel.recorded.symbol,
        covariate=None,
        p_value=0.0,
        share=share,
        words=f"the {channel.name} shows nothing {word} {reading(channel, end.value)}, in {count} places where "
        "the model goes on",
        advice=f"look at the range of the sensor, and stay within it{_remedy(channel, end.value, word)}",
        picture=Picture(
            f"Readings that end at {reading(channel, end.value)}, {shown.run}",
            "time",
            "s",
            shown.time_s,
            "readings",
            {"measured": shown.measured, "model": shown.modelled, "end": np.full(shown.time_s.size, end.value)},
            {},
        ),
    )
