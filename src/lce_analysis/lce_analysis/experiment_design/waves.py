# SPDX-License-Identifier: Apache-2.0
"""Waveforms that a design tries: random ones, variations of a good one, and their text."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from lce_analysis.options import DesignOptions
from lce_data.waveforms import SHAPES

Parts = Mapping[str, tuple[float, ...]]
"""Options of a shape of :mod:`lce_data.waveforms`, in its units."""

FILLED: Final = 0.99
"""Of the duration allowed: the parts of a waveform are rounded to samples."""


def wave_text(kind: str, parts: Parts) -> str:
    """The text by which `lce run` knows a waveform."""
    return f"{kind}:" + ",".join(f"{key}={'/'.join(f'{x:.4g}' for x in values)}" for key, values in parts.items())


def random_wave(rng: np.random.Generator, options: DesignOptions) -> tuple[str, dict[str, tuple[float, ...]]]:
    """A waveform of a random kind that fills a good part of the time allowed."""
    kind = str(rng.choice(["stairs", "hold", "cycles", "ramp", "prbs", "pulse"]))
    whole = FILLED * options.duration_s * rng.uniform(0.6, 1.0)
    low, high = np.sort(rng.uniform(0.05, 1.0, 2)) * options.max_power_w
    rest = whole * rng.uniform(0.1, 0.4)
    busy = whole - rest
    if kind == "stairs":
        steps = int(rng.integers(2, 7))
        parts = {"low": low, "high": high, "steps": steps, "hold": busy / (2 * steps - 1), "rest": rest}
    elif kind == "hold":
        count = int(rng.integers(1, 4))
        levels = tuple(rng.uniform(0.2, 1.0, count) * options.max_power_w)
        return kind, {"power": levels, "hold": (busy / count,), "rest": (rest / count,)}
    elif kind == "cycles":
        count = int(rng.integers(1, 9))
        start = busy * 0.1
        parts = {"low": low, "high": high, "period": (busy - start) / count, "count": count, "start": start}
        parts["rest"] = rest
    elif kind == "ramp":
        up, hold, down = rng.dirichlet([1.0, 0.5, 1.0]) * busy
        parts = {"high": high, "up": max(up, 0.5), "hold": hold, "down": max(down, 0.5), "rest": rest}
    elif kind == "prbs":
        order = int(rng.choice([3, 4, 5]))
        parts = {"low": low, "high": high, "bit": busy / (2**order - 1), "order": order}
        parts |= {"seed": int(rng.integers(0, 100)), "rest": rest}
    else:
        parts = {"amp": high - low, "th": busy, "offset": low, "rest": rest}
    return kind, {key: (float(value),) for key, value in parts.items()}


def varied_wave(
    rng: np.random.Generator, kind: str, parts: Parts, options: DesignOptions
) -> dict[str, tuple[float, ...]]:
    """The parts, each number changed by about a tenth, the whole within the limits."""
    shape = SHAPES[kind]
    changed: dict[str, tuple[float, ...]] = {}
    for key, values in parts.items():
        spec = shape.options[key]
        if spec.whole:
            changed[key] = values
            continue
        top = options.max_power_w if spec.unit == "W" else spec.upper
        changed[key] = tuple(float(np.clip(x * rng.lognormal(0.0, 0.1), spec.lower, top)) for x in values)
    long = shape.duration_s(changed) / (FILLED * options.duration_s)
    if long > 1.0:
        changed = {k: tuple(x / long for x in v) if shape.options[k].unit == "s" else v for k, v in changed.items()}
    return changed


def wave_from_text(protocol: str) -> tuple[str, dict[str, tuple[float, ...]]]:
    """Kind and parts of a text of :func:`wave_text`."""
    kind, _, rest = protocol.partition(":")
    pairs = (item.partition("=") for item in rest.split(","))
    return kind, {key: tuple(float(x) for x in text.split("/")) for key, _, text in pairs}
