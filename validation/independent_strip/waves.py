# SPDX-License-Identifier: Apache-2.0
"""Power signals on a 10 ms grid, written from the dissertation and not from the product's protocols.

Each returns (time_s, power_w), both (n,); the power of a sample holds until the next one. A rest without
light follows so that the strip cools to near its ambient temperature.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

SAMPLE_S = 0.01
# Table 5.1 fits about 1.3e4 samples a run at 100 Hz: 130 s, of which some 20 s are heating.
REST_S = 110.0
Wave = tuple[NDArray[np.float64], NDArray[np.float64]]


def pulse(amplitude_w: float, heating_s: float, *, offset_w: float = 1.5, rest_s: float = REST_S) -> Wave:
    """(4.20): amplitude sin(pi t / (2 T_h)) + 1.5 W while t < T_h, then nothing."""
    time = _grid(heating_s)
    return _with_rest(amplitude_w * np.sin(np.pi * time / (2.0 * heating_s)) + offset_w, rest_s)


def staircase(levels_w: Sequence[float], hold_s: float, *, rest_s: float = REST_S) -> Wave:
    """Each level [W] held for `hold_s`."""
    return _with_rest(np.repeat(np.asarray(levels_w, dtype=np.float64), _grid(hold_s).size), rest_s)


def zigzag(corners_w: Sequence[float], ramp_s: float, *, rest_s: float = REST_S) -> Wave:
    """Straight lines from corner to corner [W], `ramp_s` each."""
    at = np.arange(len(corners_w)) * ramp_s
    return _with_rest(np.interp(_grid(float(at[-1])), at, corners_w), rest_s)


def prbs(low_w: float, high_w: float, bit_s: float, bits: int, seed: int, *, rest_s: float = REST_S) -> Wave:
    """Random binary power: `bits` draws of low or high [W], `bit_s` each."""
    drawn = np.random.default_rng(seed).integers(0, 2, bits)
    return staircase([high_w if bit else low_w for bit in drawn], bit_s, rest_s=rest_s)


def _grid(duration_s: float) -> NDArray[np.float64]:
    return np.arange(round(duration_s / SAMPLE_S), dtype=np.float64) * SAMPLE_S


def _with_rest(power_w: NDArray[np.float64], rest_s: float) -> Wave:
    power = np.concatenate([power_w, np.zeros(_grid(rest_s).size + 1)])
    return np.arange(power.size, dtype=np.float64) * SAMPLE_S, power
