# SPDX-License-Identifier: Apache-2.0
"""The unit that a column most likely has, by its values; a guess, and shown as one."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import Unit
from lce_data.importing.headers import TIME, si_unit
from lce_data.importing.units import find_unit, units_of

Floats = NDArray[np.float64]

STAMPS: Final = (("ns", 1e17), ("µs", 1e14), ("ms", 1e11), ("s", 0.0))
"""Units of times since 1970, and the least number that each is of."""
SLOWEST_S: Final = 5000.0
"""A strip, a wire or a small heater responds faster than this [s]."""
SLOW_S, RARE_S = 1000.0, 50.0
"""Nobody samples as rarely as every `RARE_S` what responds in `SLOW_S`, but a camera at 10 Hz has steps of 100 ms."""
SMALLEST_GAIN: Final = 0.1
"""It warms by more than this [K/W] if it takes more than `LARGEST_POWER`."""
LARGEST_POWER: Final = 20.0
"""It takes less than this [W], as a rule."""


@dataclass(frozen=True)
class Hints:
    """What else is known of a file while the unit of a column is guessed.

    Parameters
    ----------
    header : of the column.
    warming : range of the temperature [K], None if it was not measured.
    response : time constant of the temperature, in the unit of the file's time; None if it is not known.
    """

    header: str = ""
    warming: float | None = None
    response: float | None = None


NO_HINTS: Final = Hints()


def likely_unit(quantity: str, values: Floats, hints: Hints = NO_HINTS) -> Unit:
    """The unit that values (n,), not all NaN, of the time or of a channel most likely have."""
    size = float(np.nanmax(np.abs(values)))
    if quantity == TIME:
        symbol = _time_unit(values, hints.response)
    elif quantity == "power":
        symbol = _power_unit(size, hints)
    elif si_unit(quantity) == "K":
        symbol = "K" if float(np.nanmedian(values)) > 200.0 else "°C"
    elif si_unit(quantity) == "m":
        symbol = "m" if size < 0.1 else "mm" if size <= 100.0 else "µm"
    elif si_unit(quantity) == "N":
        symbol = "N" if size <= 20.0 else "g"
    else:
        return next(iter(units_of(si_unit(quantity))))
    unit = find_unit(si_unit(quantity), symbol)
    assert unit is not None
    return unit


def _power_unit(size: float, hints: Hints) -> str:
    """Per cent if it is a drive that ends at 100, milliwatts if it is large and hardly warms anything."""
    named_power = re.search(r"pow|watt|leist|^p\d*$", hints.header.casefold()) is not None
    if 10.0 < size <= 101.0 and not named_power:
        return "%"
    if size > 1e3 or (size > LARGEST_POWER and hints.warming is not None and hints.warming / size < SMALLEST_GAIN):
        return "mW"
    return "W"


def _time_unit(values: Floats, response: float | None) -> str:
    """A stamp since 1970 says its unit by its size; a shorter time is in milliseconds if all else would be too slow."""
    start = float(np.nanmin(values))
    if start > 1e9:
        return next(symbol for symbol, least in STAMPS if start > least)
    return "ms" if is_in_milliseconds(values, response) else "s"


def is_in_milliseconds(time: Floats, response: float | None) -> bool:
    """Whether a time, taken for seconds, has steps of 1 s and more and a temperature that is too slow for them."""
    if response is None:
        return False
    step = float(np.median(np.diff(time)))
    return step >= 1.0 and response > (SLOWEST_S if step < RARE_S else SLOW_S)


def response_time(time: Floats, value: Floats) -> float | None:
    """About the time constant of a signal (n,): its range over its steepest slope; None if it hardly moves.

    The slope is taken between means of 200 sections of equal numbers of samples, which is beyond most of the noise.
    """
    there = np.isfinite(value) & np.isfinite(time)
    time, value = time[there], value[there]
    sections = min(200, time.size // 2)
    if sections < 8:
        return None
    edges = np.linspace(0, time.size, sections + 1).astype(int)[:-1]
    counts = np.diff(np.append(edges, time.size))
    t, v = (np.add.reduceat(column, edges) / counts for column in (time - time[0], value))
    steps = np.diff(t)
    steepest = float(np.max(np.abs(np.diff(v)[steps > 0] / steps[steps > 0]), initial=0.0))
    return float(np.ptp(v)) / steepest if steepest > 0.0 else None
