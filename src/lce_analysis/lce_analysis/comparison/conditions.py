# SPDX-License-Identifier: Apache-2.0
"""In which circumstances the error sits: quarters of the temperature range, branches, holds and ramps, cycles, runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.units import KELVIN

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

BRANCHES: Final = ("heating", "cooling")
TURN_K: Final = 2.0
"""A turn of the temperature by less than this does not begin another cycle."""
HOLD_SHARE: Final = 0.05
"""A temperature that changes by less than this share of its fastest rate is held."""
STILL_K_S: Final = 1e-3
"""So slow a change is a hold in any run."""
STEPS: Final = 16
"""Steps of the temperature range of which the stretch with most of the error is made."""
SIMPLER: Final = 0.75
"""A narrower description must need less than this part of the samples, or the simpler one stands."""


@dataclass(frozen=True)
class Regime:
    """What the strip was doing at each time (n,), by the model's own noise-free temperature.

    power_w is held from sample to sample, cycle counts from 1 within the run.
    """

    time_s: Floats
    temperature_c: Floats
    rate_k_s: Floats
    power_w: Floats
    heating: Flags
    hold: Flags
    cycle: NDArray[np.intp]

    def at(self, time_s: Floats) -> "Regime":
        """The regime at other times (m,)."""
        index = np.clip(np.searchsorted(self.time_s, time_s + 1e-9, side="right") - 1, 0, self.time_s.size - 1)
        return Regime(
            time_s=time_s,
            temperature_c=np.interp(time_s, self.time_s, self.temperature_c),
            rate_k_s=np.interp(time_s, self.time_s, self.rate_k_s),
            power_w=self.power_w[index],
            heating=self.heating[index],
            hold=self.hold[index],
            cycle=self.cycle[index],
        )


def regime(time_s: Floats, temperature_k: Floats, power_w: Floats) -> Regime:
    """The regime of a run from its temperature and power (n,)."""
    rate = np.gradient(temperature_k, time_s)
    branch, cycle = _turns(temperature_k)
    hold = np.abs(rate) <= max(STILL_K_S, HOLD_SHARE * float(np.max(np.abs(rate))))
    return Regime(time_s, temperature_k - KELVIN, rate, power_w, branch > 0, hold, cycle)


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
    """Share of the squared error and of the samples in one regime, and the rms of the residual there (NaN: nothing)."""

    error_share: float
    sample_share: float
    rms: float


@dataclass(frozen=True)
class RegimeShare(Share):
    """The share of a quarter of the temperature range (bounds in °C), a branch, and held or ramping."""

    branch: str
    lower_c: float
    upper_c: float
    held: bool

    def among(self, regime: Regime) -> Flags:
        """Which times (n,) of a run belong to it."""
        inside = (regime.temperature_c >= self.lower_c) & (regime.temperature_c <= self.upper_c)
        return np.asarray(inside & (regime.heating == (self.branch == "heating")) & (regime.hold == self.held))


def spans(time_s: Floats, here: Flags) -> list[tuple[float, float]]:
    """First and last time [s] of each stretch of samples (n,) that are marked."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], here, [False]]).astype(np.int8)))
    return [(float(time_s[a]), float(time_s[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


@dataclass(frozen=True)
class Stretch(Share):
    """A stretch of the temperature (°C), on one branch or both (None), held, ramping or both (None)."""

    branch: str | None
    held: bool | None
    lower_c: float
    upper_c: float


@dataclass(frozen=True)
class ErrorShares:
    """Where the squared error of one quantity sits, all runs together; the shares of each group add up to one.

    regimes : quarter of the temperature range x branch x hold or ramp, coldest quarter first.
    quarters, branches, holds, runs : the same error by one of them alone; keys as in a table.
    cycles : by run and by cycle within it.
    most : the smallest stretch that holds at least half of the error.
    """

    regimes: tuple[RegimeShare, ...]
    quarters: Mapping[str, Share]
    branches: Mapping[str, Share]
    holds: Mapping[str, Share]
    runs: Mapping[str, Share]
    cycles: Mapping[str, Mapping[int, Share]]
    most: Stretch


def error_shares(members: Sequence[tuple[str, Regime, Floats]]) -> ErrorShares:
    """Shares over all members: name of a run, its regime (n,), its residual (n,)."""
    temperature = np.concatenate([r.temperature_c for _, r, _ in members])
    heating = np.concatenate([r.heating for _, r, _ in members])
    hold = np.concatenate([r.hold for _, r, _ in members])
    cycle = np.concatenate([r.cycle for _, r, _ in members])
    run = np.repeat(np.arange(len(members)), [e.size for _, _, e in members])
    squared = np.concatenate([e for _, _, e in members]) ** 2
    edges = np.linspace(float(temperature.min()), float(temperature.max()), 5)
    quarter = np.clip(np.searchsorted(edges, temperature, side="right") - 1, 0, 3)

    def share(here: Flags) -> tuple[float, float, float]:
        part, total = float(np.sum(squared[here])), float(np.sum(squared))
        rms = float(np.sqrt(np.mean(squared[here]))) if here.any() else float("nan")
        return part / total if total > 0.0 else 0.0, float(np.mean(here)), rms

    return ErrorShares(
        regimes=tuple(
            RegimeShare(
                *share((heating == (branch == "heating")) & (quarter == q) & (hold == held)),
                branch,
                float(edges[q]),
                float(edges[q + 1]),
                held,
            )
            for branch in BRANCHES
            for q in range(4)
            for held in (False, True)
        ),
        quarters={f"{edges[q]:.0f}–{edges[q + 1]:.0f} °C": Share(*share(quarter == q)) for q in range(4)},
        branches={branch: Share(*share(heating == (branch == "heating"))) for branch in BRANCHES},
        holds={"ramp": Share(*share(~hold)), "hold": Share(*share(hold))},
        runs={name: Share(*share(run == i)) for i, (name, _, _) in enumerate(members)},
        cycles={
            name: {int(n): Share(*share((run == i) & (cycle == n))) for n in np.unique(r.cycle)}
            for i, (name, r, _) in enumerate(members)
        },
        most=_most(temperature, heating, hold, squared),
    )


def _most(temperature: Floats, heating: Flags, hold: Flags, squared: Floats) -> Stretch:
    """The smallest stretch, by its samples, that holds at least half of the squared error.

    Tried from the simplest description (a range of temperatures) to the most particular (… on one branch, while held).
    """
    edges = np.linspace(float(temperature.min()), float(temperature.max()), STEPS + 1)
    step = np.clip(np.searchsorted(edges, temperature, side="right") - 1, 0, STEPS - 1)
    total = float(np.sum(squared)) or 1.0
    best: Stretch | None = None
    for branch, held, here in _descriptions(heating, hold):
        error = np.concatenate([[0.0], np.cumsum(np.bincount(step[here], squared[here], STEPS))]) / total
        count = np.concatenate([[0], np.cumsum(np.bincount(step[here], minlength=STEPS))])
        enough = [
            (count[j] - count[i], i, j)
            for i in range(STEPS)
            for j in range(i + 1, STEPS + 1)
            if error[j] - error[i] >= 0.5
        ]
        if not enough:
            continue
        n, i, j = min(enough)
        if best is None or n < SIMPLER * best.sample_share * squared.size:
            share = float(error[j] - error[i])
            rms = float(np.sqrt(share * total / max(n, 1)))
            best = Stretch(share, float(n / squared.size), rms, branch, held, float(edges[i]), float(edges[j]))
    return best or Stretch(0.0, 1.0, 0.0, None, None, float(edges[0]), float(edges[-1]))


def _descriptions(heating: Flags, hold: Flags) -> Iterator[tuple[str | None, bool | None, Flags]]:
    branches: list[tuple[str | None, Flags]] = [
        (None, np.ones_like(heating)),
        ("heating", heating),
        ("cooling", ~heating),
    ]
    for branch, on in branches:
        yield branch, None, on
    for branch, on in branches:
        for held in (False, True):
            yield branch, held, on & (hold == held)
