# SPDX-License-Identifier: Apache-2.0
"""What looks wrong about a run although it can be read: a unit, a sign or a gap, each with its cure.

Every rule says what it saw and what to do. None changes the run.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.importing.plausible import LARGEST_POWER, SMALLEST_GAIN, is_in_milliseconds, response_time
from lce_data.losses import lost_samples
from lce_data.run import Run, Series
from lce_data.units import KELVIN

Floats = NDArray[np.float64]

OPPOSITE: Final = -0.5
"""Correlation from which on two signals go opposite ways."""
GAP_STEPS, GAP_S = 20.0, 2.0
"""A gap is longer than so many median steps, and than this [s]."""
ROOM_K: Final = (270.0, 330.0)
"""Numbers [°C] that a room has in kelvin."""
ENOUGH: Final = 20_000
"""Samples of a series that the rules look at, but for that on gaps."""
GRID: Final = 1000
"""Times at which power and temperature are compared."""
LAGS: Final = np.geomspace(0.003, 0.3, 5)
"""Time constants that are tried to follow the power, as shares of the record."""


def suspicions(run: Run) -> tuple[str, ...]:
    """Sentences about a run: what looks wrong, and the cure; none for a run without anything odd.

    They come before any fit: a time in ms, a power in mW, kelvin taken for °C, a displacement that falls while the
    temperature rises, a temperature that falls under power, samples that were lost on the way to the recorder, a gap
    during which the power would be held.
    """
    few = replace(run, series={channel: _thinned(series) for channel, series in run.series.items()})
    rules = (_milliseconds, _milliwatts, _kelvin, _flipped_displacement, _flipped_power)
    found = (*(rule(few) for rule in rules), lost_samples(run), _gap(run))
    return tuple(f"{run.name}: {sentence}" for sentence in found if sentence)


def _thinned(series: Series) -> Series:
    """Every so many samples of a long series, `ENOUGH` or up to twice as many."""
    every = slice(None, None, max(1, series.time_s.size // ENOUGH))
    return Series(series.time_s[every], series.value[every])


def _milliseconds(run: Run) -> str:
    warm = run.temperature or run.displacement
    if warm is None:
        return ""
    response = response_time(warm.time_s, warm.value)
    if not is_in_milliseconds(warm.time_s, response):
        return ""
    step = float(np.median(np.diff(warm.time_s)))
    return (
        f"a sample every {step:g} s and a response over {response or 0.0:.0f} s; is the time in ms? "
        "Divide it by 1000, or: lce import FILE --column time=NAME:ms"
    )


def _milliwatts(run: Run) -> str:
    if run.power is None:
        return ""
    most = float(run.power.value.max())
    if most <= LARGEST_POWER:
        return ""
    if run.temperature is not None:
        gain = float(np.ptp(run.temperature.value)) / most
        if gain >= SMALLEST_GAIN:
            return ""
        seen = f"{most:g} W warm by {gain * most:.3g} K only"
    elif most <= 1e3:
        return ""
    else:
        seen = f"the power reaches {most:g} W"
    return f"{seen}; is the power in mW? Divide it by 1000, or: lce import FILE --column power=NAME:mW"


def _kelvin(run: Run) -> str:
    if run.temperature is None:
        return ""
    coldest = float(run.temperature.value.min()) - KELVIN
    if not ROOM_K[0] < coldest < ROOM_K[1]:
        return ""
    return (
        f"the temperature is never below {coldest:.0f} °C; is it in kelvin? Subtract {KELVIN}, or: lce import FILE "
        "--column temperature=NAME:K"
    )


def _flipped_displacement(run: Run) -> str:
    if run.temperature is None or run.displacement is None:
        return ""
    moved = np.interp(run.temperature.time_s, run.displacement.time_s, run.displacement.value)
    if _correlation(run.temperature.value, moved) > OPPOSITE:
        return ""
    return (
        "the displacement falls while the temperature rises; contraction counts positive. Flip its sign, or: "
        "lce import FILE --column displacement=NAME:-mm"
    )


def _flipped_power(run: Run) -> str:
    if run.power is None or run.temperature is None:
        return ""
    measured_s = run.temperature.time_s
    time_s = np.linspace(measured_s[0], measured_s[-1], GRID)
    warm = np.interp(time_s, measured_s, run.temperature.value)
    held = run.power.value[np.maximum(np.searchsorted(run.power.time_s, time_s, side="right") - 1, 0)]
    follows = [_correlation(warm, _lagged(held, share * GRID)) for share in LAGS]
    strongest = max(follows, key=abs)
    if strongest > OPPOSITE:
        return ""
    return (
        "the temperature falls while the power is on; is a sign flipped, or are two columns mixed up? "
        "lce import FILE --column temperature=NAME:degC --column power=NAME:W picks them"
    )


def _gap(run: Run) -> str:
    """The longest interval in which nothing was recorded and the power was on before."""
    if run.power is None:
        return ""
    time_s = max((series.time_s for series in run.series.values()), key=len)
    steps = np.diff(time_s)
    gaps = np.flatnonzero(steps > max(GAP_STEPS * float(np.median(steps)), GAP_S))
    for series in run.series.values():  # another channel may have gone on
        inside = [
            np.searchsorted(series.time_s, time_s[gaps], "right"),
            np.searchsorted(series.time_s, time_s[gaps + 1]),
        ]
        gaps = gaps[inside[0] == inside[1]]
    held = run.power.value[np.maximum(np.searchsorted(run.power.time_s, time_s[gaps], side="right") - 1, 0)]
    on = held > 0.02 * max(float(run.power.value.max()), 0.0)
    gaps, held = gaps[on], held[on]
    if not gaps.size:
        return ""
    longest = int(np.argmax(steps[gaps]))
    begin_s, end_s = time_s[gaps[longest]], time_s[gaps[longest] + 1]
    others = f", and {gaps.size - 1} more" if gaps.size > 1 else ""
    return (
        f"nothing was recorded from {begin_s:.6g} to {end_s:.6g} s{others}, and {held[longest]:.3g} W count as "
        "held for all that time. Split the recording there, or add a row with the power as it was"
    )


def _lagged(value: Floats, tau: float) -> Floats:
    """Evenly spaced values (n,) behind a first-order lag with a time constant of ``tau`` samples."""
    response = np.exp(-np.arange(value.size) / tau)
    return np.convolve(value - value[0], response)[: value.size]


def _correlation(one: Floats, other: Floats) -> float:
    """Pearson's correlation; 0 if a signal does not move."""
    spread = float(np.std(one) * np.std(other))
    return float(np.mean((one - one.mean()) * (other - other.mean()))) / spread if spread > 0.0 else 0.0
