# SPDX-License-Identifier: Apache-2.0
"""In which circumstances the error sits: quarters of the temperature range, branches, holds and ramps, cycles."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_model import KELVIN

Floats = NDArray[np.float64]

BRANCHES: Final = ("heating", "cooling")
TURN_K: Final = 2.0
"""A turn of the temperature by less than this does not begin another cycle."""
HOLD_SHARE: Final = 0.05
"""A temperature that changes by less than this share of its fastest rate is held."""


@dataclass(frozen=True)
class Regime:
    """What the strip was doing at each sample (n,) of a series, by the model's own noise-free temperature."""

    temperature_c: Floats
    rate_k_s: Floats
    power_w: Floats
    heating: NDArray[np.bool_]
    hold: NDArray[np.bool_]
    cycle: NDArray[np.intp]


def regime(time_s: Floats, temperature_k: Floats, power_w: Floats, at_s: Floats) -> Regime:
    """The regime at the times ``at_s``, from temperature and held power (n,) at ``time_s``."""
    rate = np.gradient(temperature_k, time_s)
    index = np.clip(np.searchsorted(time_s, at_s + 1e-9, side="right") - 1, 0, time_s.size - 1)
    fastest = float(np.max(np.abs(rate)))
    direction, cycle = _turns(temperature_k)
    return Regime(
        temperature_c=np.interp(at_s, time_s, temperature_k) - KELVIN,
        rate_k_s=np.interp(at_s, time_s, rate),
        power_w=power_w[index],
        heating=(direction > 0)[index],
        hold=(np.abs(rate) < HOLD_SHARE * fastest)[index],
        cycle=cycle[index],
    )


def _turns(temperature_k: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Branch (+1, -1) and cycle (from 1) at each time; turns smaller than TURN_K are left out."""
    direction = np.empty(temperature_k.size, dtype=np.intp)
    cycle = np.empty(temperature_k.size, dtype=np.intp)
    branch, number, extreme, since = 1, 1, float(temperature_k[0]), 0
    for i, t in enumerate(temperature_k.tolist()):
        if (t - extreme) * branch >= 0.0:
            extreme, since = t, i
        elif abs(t - extreme) > TURN_K:
            branch = -branch
            number += branch > 0
            # The turn was where the extreme was, not where it became certain.
            direction[since + 1 : i], cycle[since + 1 : i] = branch, number
            extreme, since = t, i
        direction[i], cycle[i] = branch, number
    return direction, cycle


@dataclass(frozen=True)
class Share:
    """A regime and its share of the squared error and of the samples; bounds in °C."""

    branch: str
    lower_c: float
    upper_c: float
    held: bool
    error_share: float
    sample_share: float


def shares(regimes: Sequence[Regime], residuals: Sequence[Floats]) -> tuple[Share, ...]:
    """Shares of quarter × branch × hold/ramp over all runs together, coldest quarter first."""
    temperature = np.concatenate([r.temperature_c for r in regimes])
    heating = np.concatenate([r.heating for r in regimes])
    hold = np.concatenate([r.hold for r in regimes])
    squared = np.concatenate(residuals) ** 2
    edges = np.linspace(float(temperature.min()), float(temperature.max()), 5)
    quarter = np.clip(np.searchsorted(edges, temperature, side="right") - 1, 0, 3)
    found = []
    for branch in BRANCHES:
        for q in range(4):
            for held in (False, True):
                here = (heating == (branch == "heating")) & (quarter == q) & (hold == held)
                found.append(Share(
                    branch, float(edges[q]), float(edges[q + 1]), held,
                    _part(squared[here], squared), float(np.mean(here)),
                ))
    return tuple(found)


def by_cycle(regimes: Sequence[Regime], residuals: Sequence[Floats]) -> Mapping[int, float]:
    """Share of the squared error in each cycle (numbered within its run), all runs together."""
    cycle = np.concatenate([r.cycle for r in regimes])
    squared = np.concatenate(residuals) ** 2
    return {int(n): _part(squared[cycle == n], squared) for n in np.unique(cycle)}


def _part(some: Floats, everything: Floats) -> float:
    total = float(np.sum(everything))
    return float(np.sum(some)) / total if total > 0.0 else 0.0


def where_most(found: Sequence[Share]) -> tuple[str, float, float, float]:
    """Branch, temperatures (°C) and share of the error of the worst stretch of neighbouring quarters."""
    cells = {
        (branch, q): sum(s.error_share for s in found if s.branch == branch and s.lower_c == low)
        for branch in BRANCHES
        for q, low in enumerate(_edges(found)[:-1])
    }
    (branch, worst), share = max(cells.items(), key=lambda item: item[1])
    low = high = worst
    for step in (-1, 1):
        near = worst + step
        if cells.get((branch, near), 0.0) > 0.5 * share:
            low, high = min(low, near), max(high, near)
    edges = _edges(found)
    return branch, edges[low], edges[high + 1], sum(cells[branch, q] for q in range(low, high + 1))


def _edges(found: Sequence[Share]) -> list[float]:
    lows = sorted({s.lower_c for s in found})
    return [*lows, max(s.upper_c for s in found)]
