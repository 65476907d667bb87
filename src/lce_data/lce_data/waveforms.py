# SPDX-License-Identifier: Apache-2.0
"""The waveforms a protocol can name, as tables of options and lists of pieces. Powers in W, times in s."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.errors import LceError

Floats = NDArray[np.float64]

RATE_HZ: Final = 100.0
"""Samples per second of every waveform, the rate of `laser/power_command`."""

Values = Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class Option:
    """One option of a protocol: default, allowed range, unit, meaning; `many` takes a list a/b/c."""

    default: tuple[float, ...]
    lower: float
    upper: float
    unit: str
    meaning: str
    whole: bool = False
    many: bool = False

    def read(self, where: str, key: str, text: str) -> tuple[float, ...]:
        """Read the values in `text`. Raises LceError that names the value and the allowed range."""
        parts = text.split("/") if self.many else [text]
        try:
            values = tuple(float(part) for part in parts)
        except ValueError:
            raise LceError(f"{where}: {key} = {text!r} is not a number") from None
        for value in values:
            if not self.lower <= value <= self.upper:
                unit = f" {self.unit}" if self.unit else ""
                raise LceError(f"{where}: {key} = {value:g} is outside {self.lower:g} .. {self.upper:g}{unit}")
            if self.whole and value != int(value):
                raise LceError(f"{where}: {key} = {value:g} is not a whole number")
        return values


@dataclass(frozen=True)
class Piece:
    """A part of a waveform: its length in s, and its power in W as a function of the time in it (n,)."""

    duration_s: float
    power_w: Callable[[Floats], Floats]


@dataclass(frozen=True)
class Shape:
    """A kind of waveform: what it does, its options, and the function that puts its pieces together."""

    meaning: str
    options: Mapping[str, Option]
    build: Callable[[Values], list[Piece]]

    def pieces(self, given: Values) -> list[Piece]:
        """Put the pieces together from the options given and the defaults of the others."""
        return self.build({k: given.get(k, option.default) for k, option in self.options.items()})

    def duration_s(self, given: Values) -> float:
        """Length of the waveform [s]."""
        return sum(piece.duration_s for piece in self.pieces(given))

    def power_w(self, given: Values) -> Floats:
        """Power [W] (n,) at RATE_HZ; it ends with 0."""
        pieces = self.pieces(given)
        parts = [piece.power_w(np.arange(round(piece.duration_s * RATE_HZ)) / RATE_HZ) for piece in pieces]
        return np.append(np.concatenate(parts), 0.0)


def _hold(power_w: float, duration_s: float) -> Piece:
    return Piece(duration_s, lambda t: np.full(t.size, power_w))


def _line(start_w: float, end_w: float, duration_s: float) -> Piece:
    return Piece(duration_s, lambda t: start_w + (end_w - start_w) * t / duration_s)


def _pulse(o: Values) -> list[Piece]:
    amp, th, offset = o["amp"][0], o["th"][0], o["offset"][0]
    heat = Piece(th, lambda t: amp * np.sin(math.pi / (2 * th) * t) + offset)
    return [heat, _hold(0.0, o["rest"][0])]


def _stairs(o: Values) -> list[Piece]:
    levels = np.linspace(o["low"][0], o["high"][0], int(o["steps"][0]))
    both = [*levels, *levels[-2::-1]]
    return [*(_hold(power_w, o["hold"][0]) for power_w in both), _hold(0.0, o["rest"][0])]


def _holds(o: Values) -> list[Piece]:
    hold, rest = o["hold"][0], o["rest"][0]
    return [piece for power_w in o["power"] for piece in (_hold(power_w, hold), _hold(0.0, rest))]


def _cycles(o: Values) -> list[Piece]:
    low, high, half = o["low"][0], o["high"][0], o["period"][0] / 2
    cycle = [_line(low, high, half), _line(high, low, half)]
    return [_line(0.0, low, o["start"][0]), *cycle * int(o["count"][0]), _hold(0.0, o["rest"][0])]


def _ramp(o: Values) -> list[Piece]:
    high = o["high"][0]
    up, top, down = _line(0.0, high, o["up"][0]), _hold(high, o["hold"][0]), _line(high, 0.0, o["down"][0])
    return [up, top, down, _hold(0.0, o["rest"][0])]


_TAPS: Final = {3: (1,), 4: (1,), 5: (2,), 6: (1,), 7: (1,), 8: (1, 2, 7), 9: (4,), 10: (3,), 11: (2,)}
"""Exponents k of x^n + Σ x^k + 1, primitive over GF(2), by order n: the reciprocals of scipy's own.

With them a protocol gives the sequence that was recorded under its name since the first version.
"""


def prbs_bits(order: int, seed: int) -> NDArray[np.bool_]:
    """One period, 2^order - 1 bits, of a maximal-length sequence; the seed says where it starts.

    Raises LceError for an order outside 3 .. 11.
    """
    from scipy.signal import max_len_seq

    if order not in _TAPS:
        raise LceError(f"prbs: order = {order} is outside {min(_TAPS)} .. {max(_TAPS)}")
    register = 1 + seed % (2**order - 1)
    state = [register >> k & 1 for k in range(order)]
    bits, _ = max_len_seq(order, state=state, taps=_TAPS[order])
    return bits.astype(bool)


def _prbs(o: Values) -> list[Piece]:
    bits = prbs_bits(int(o["order"][0]), int(o["seed"][0]))
    once = [_hold(o["high" if bit else "low"][0], o["bit"][0]) for bit in bits]
    return [*once * int(o["repeat"][0]), _hold(0.0, o["rest"][0])]


def _power(default: float, meaning: str) -> Option:
    return Option((default,), 0.0, 100.0, "W", meaning)


def _seconds(default: float, meaning: str, lower: float = 0.0) -> Option:
    return Option((default,), lower, 36000.0, "s", meaning)


def _count(default: int, lower: int, upper: int, meaning: str) -> Option:
    return Option((float(default),), lower, upper, "", meaning, whole=True)


_REST = _seconds(80.0, "dark time afterwards, for cooling")

SHAPES: Mapping[str, Shape] = {
    "pulse": Shape(
        "(4.20): P = amp sin(pi t / (2 th)) + offset until th, then 0",
        {
            "amp": Option((0.2,), -100.0, 100.0, "W", "amplitude"),
            "th": _seconds(30.0, "heating time", 0.1),
            "offset": _power(1.5, "constant part"),
            "rest": _REST,
        },
        _pulse,
    ),
    "stairs": Shape(
        "a staircase up and down again",
        {
            "low": _power(0.3, "first level"),
            "high": _power(1.8, "highest level"),
            "steps": _count(6, 2, 1000, "levels on the way up"),
            "hold": _seconds(20.0, "time at each level", 0.01),
            "rest": _REST,
        },
        _stairs,
    ),
    "hold": Shape(
        "constant power, one level after the other (power=0.8/1.2/1.6)",
        {
            "power": Option((0.8, 1.2, 1.6), 0.0, 100.0, "W", "levels", many=True),
            "hold": _seconds(60.0, "time at each level", 0.01),
            "rest": _seconds(60.0, "dark time after each level"),
        },
        _holds,
    ),
    "cycles": Shape(
        "triangles between two powers, for inner loops",
        {
            "low": _power(0.7, "lower power"),
            "high": _power(1.6, "upper power"),
            "period": _seconds(40.0, "time for one up and down", 0.02),
            "count": _count(4, 1, 10000, "how many"),
            "start": _seconds(20.0, "ramp from 0 to low"),
            "rest": _REST,
        },
        _cycles,
    ),
    "ramp": Shape(
        "up, hold, down",
        {
            "high": _power(1.8, "highest power"),
            "up": _seconds(60.0, "time of the rise", 0.01),
            "hold": _seconds(0.0, "time at the top"),
            "down": _seconds(60.0, "time of the fall", 0.01),
            "rest": _REST,
        },
        _ramp,
    ),
    "prbs": Shape(
        "maximal-length pseudo-random binary sequence between two powers",
        {
            "low": _power(0.6, "power of a 0"),
            "high": _power(1.6, "power of a 1"),
            "bit": _seconds(3.0, "time of one bit", 0.01),
            "order": _count(6, 3, 11, "register length n; 2^n - 1 bits"),
            "seed": _count(1, 0, 2**31 - 1, "where in the sequence it starts"),
            "repeat": _count(1, 1, 100, "how many times through"),
            "rest": _REST,
        },
        _prbs,
    ),
}
