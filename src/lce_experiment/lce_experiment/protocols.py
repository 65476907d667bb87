# SPDX-License-Identifier: Apache-2.0
"""What the laser is asked to do: a PROTOCOL text becomes a power waveform at 100 Hz.

A protocol is a name with options, `pulse:amp=0.2,th=30`, or the path of a CSV file with the columns
`time_s,power_w`; `campaign` and its parts are lists of protocols, one run each. Powers are in W, times in s.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lce_data.errors import LceError, did_you_mean
from lce_data.wave_file import MAX_DURATION_S, read_wave
from lce_data.waveforms import RATE_HZ, SHAPES, Floats


@dataclass(frozen=True, eq=False)
class Wave:
    """Laser power over time, each value held until the next sample.

    time_s (n,) starts at 0 with 0.01 s steps; power_w (n,) is finite and not negative, and ends with 0.
    `text` is the protocol that made it, `name` what its recording is called.
    """

    name: str
    text: str
    time_s: Floats
    power_w: Floats

    def __post_init__(self) -> None:
        lowest = int(np.argmin(self.power_w))
        if self.power_w[lowest] < 0:
            raise LceError(
                f"{self.text}: the power falls to {self.power_w[lowest]:.4g} W at {self.time_s[lowest]:g} s;"
                " a laser gives 0 W or more"
            )

    @property
    def duration_s(self) -> float:
        """Length of the waveform in s."""
        return float(self.time_s[-1])


_CHAPTER4 = tuple(f"pulse:amp={a},th={t}" for a, t in ((0.2, 30), (0.2, 40), (0.2, 50), (0.25, 25), (0.25, 35)))
_CHAPTER5 = tuple(f"pulse:amp=0.4,th={t}" for t in (16, 17, 18, 19, 20, 21))

CAMPAIGNS: Mapping[str, tuple[str, ...]] = {
    "campaign": (*_CHAPTER4, *_CHAPTER5, "stairs", "hold", "cycles", "prbs"),
    "chapter4": _CHAPTER4,
    "chapter5": _CHAPTER5,
}
"""Lists of protocols, one recording each: the standard campaign, and the pulses of the printed tables."""


def load(text: str) -> tuple[Wave, ...]:
    """Waveforms of the protocol `text`: one, or several for a campaign. Raises LceError."""
    if text in CAMPAIGNS:
        return tuple(one(part) for part in CAMPAIGNS[text])
    return (one(text),)


def one(text: str) -> Wave:
    """The waveform of a single protocol or wave file. Raises LceError naming what is allowed."""
    if text in CAMPAIGNS:
        raise LceError(
            f"{text} is {len(CAMPAIGNS[text])} runs, not one; name one of them, such as {CAMPAIGNS[text][0]}"
        )
    kind, _, rest = text.partition(":")
    if kind in SHAPES:
        return _from_shape(text, kind, rest)
    path = Path(text)
    if path.suffix.lower() == ".csv" or path.is_file():
        time_s, power_w = read_wave(path)
        return _on_grid(re.sub(r"[^\w.+-]+", "_", path.stem), text, time_s, power_w)
    known = [*SHAPES, *CAMPAIGNS]
    raise LceError(
        f"unknown protocol {text!r}{did_you_mean(kind, known)}; it is one of {', '.join(known)}, or a CSV file with "
        "time_s,power_w"
    )


def _from_shape(text: str, kind: str, rest: str) -> Wave:
    shape, given = SHAPES[kind], {}
    for item in filter(None, rest.split(",")):
        key, equals, value = item.partition("=")
        key = key.strip().lower().replace("_", "")
        if not equals or key not in shape.options:
            raise LceError(
                f"{kind}: unknown option {item.strip()!r}{did_you_mean(key, shape.options)}; "
                f"it has {', '.join(shape.options)}"
            )
        if key in given:
            raise LceError(f"{kind}: option {key!r} is given twice")
        given[key] = shape.options[key].read(kind, key, value)
    total_s = shape.duration_s(given)
    if total_s > MAX_DURATION_S:
        raise LceError(f"{text}: {total_s:g} s is longer than {MAX_DURATION_S:g} s")
    samples = shape.power_w(given)
    name = "_".join([kind, *(f"{k}{'-'.join(f'{v:g}' for v in given[k])}" for k in given)])
    return Wave(name, text, np.arange(samples.size) / RATE_HZ, samples)


def _on_grid(name: str, text: str, time_s: Floats, power_w: Floats) -> Wave:
    """Sample and hold a wave file at 100 Hz; dark before its first row, 0 after its last."""
    grid = np.arange(math.ceil(round(time_s[-1] * RATE_HZ, 6)) + 2) / RATE_HZ
    row = np.searchsorted(time_s, grid + 1e-9, side="right") - 1
    samples = np.where(row >= 0, power_w[np.maximum(row, 0)], 0.0)
    samples[-1] = 0.0
    return Wave(name, text, grid, samples)


def explain() -> str:
    """The text of `lce run --help` on protocols."""
    lines = ["protocols (power in W, time in s):"]
    for name, shape in SHAPES.items():
        options = ",".join(f"{k}={'/'.join(f'{v:g}' for v in o.default)}" for k, o in shape.options.items())
        lines += [f"  {name}:{options}", f"      {shape.meaning}"]
    lines.append("  FILE.csv\n      columns time_s,power_w; each power is held until the next row")
    for name, parts in CAMPAIGNS.items():
        lines.append(f"  {name}\n      {len(parts)} runs, one bag each: {' '.join(parts)}")
    return "\n".join(lines)
