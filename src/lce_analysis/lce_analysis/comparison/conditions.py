# SPDX-License-Identifier: Apache-2.0
"""In which circumstances the error sits: quarters of the temperature range, branches, holds and ramps, cycles, runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_analysis.options import CompareOptions
from lce_data.units import KELVIN

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

BRANCHES: Final = ("heating", "cooling")
MOST_DECIMALS: Final = 3
"""Of the temperature [°C] at the ends of a quarter of its range."""


@dataclass(frozen=True)
class OperatingConditions:
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

    def at(self, time_s: Floats) -> "OperatingConditions":
        """The operating conditions at other times (m,)."""
        index = np.clip(np.searchsorted(self.time_s, time_s + 1e-9, side="right") - 1, 0, self.time_s.size - 1)
        return OperatingConditions(
            time_s=time_s,
            temperature_c=np.interp(time_s, self.time_s, self.temperature_c),
            rate_k_s=np.interp(time_s, self.time_s, self.rate_k_s),
            power_w=self.power_w[index],
            heating=self.heating[index],
            hold=self.hold[index],
            cycle=self.cycle[index],
        )


def operating_conditions(
    time_s: Floats, temperature_k: Floats, power_w: Floats, options: CompareOptions = CompareOptions()
) -> OperatingConditions:
    """The operating conditions of a run from its temperature and power (n,)."""
    rate = np.gradient(temperature_k, time_s)
    branch, cycle = _turns(temperature_k, options.turn_k)
    hold = np.abs(rate) <= max(options.still_k_s, options.hold_share * float(np.max(np.abs(rate))))
    return OperatingConditions(time_s, temperature_k - KELVIN, rate, power_w, branch > 0, hold, cycle)


def _turns(temperature_k: Floats, turn_k: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Branch (+1, -1) and cycle (from 1) at each time; turns smaller than ``turn_k`` are left out."""
    direction = np.empty(temperature_k.size, dtype=np.intp)
    cycle = np.empty(temperature_k.size, dtype=np.intp)
    branch, number, extreme, since = 1, 1, float(temperature_k[0]), 0
    for i, t in enumerate(temperature_k.tolist()):
        if (t - extreme) * branch >= 0.0:
            extreme, since = t, i
        elif abs(t - extreme) > turn_k:
            branch = -branch
            number += branch > 0
            # The turn was where the extreme was, not where it became certain.
            direction[since + 1 : i], cycle[since + 1 : i] = branch, number
            extreme, since = t, i
        direction[i], cycle[i] = branch, number
    return direction, cycle


@dataclass(frozen=True)
class Share:
    """Share of squared error and samples under a condition; rms of the residual there (NaN: no sample)."""

    error_share: float
    sample_share: float
    rms: float


@dataclass(frozen=True)
class ConditionShare(Share):
    """The share of a quarter of the temperature range (bounds in °C), a branch, and held or ramping."""

    branch: str
    lower_c: float
    upper_c: float
    held: bool

    def among(self, conditions: OperatingConditions) -> Flags:
        """Which times (n,) of a run belong to it."""
        inside = (conditions.temperature_c >= self.lower_c) & (conditions.temperature_c <= self.upper_c)
        return np.asarray(inside & (conditions.heating == (self.branch == "heating")) & (conditions.hold == self.held))


def spans(time_s: Floats, here: Flags) -> list[tuple[float, float]]:
    """First and last time [s] of each interval of samples (n,) that are marked."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], here, [False]]).astype(np.int8)))
    return [(float(time_s[a]), float(time_s[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


@dataclass(frozen=True)
class Interval(Share):
    """An interval of the temperature (°C), on one branch or both (None), held, ramping or both (None)."""

    branch: str | None
    held: bool | None
    lower_c: float
    upper_c: float


@dataclass(frozen=True)
class ErrorShares:
    """Where the squared error of one quantity sits, all runs together; the shares of each group add up to one.

    conditions : quarter of the temperature range x branch x hold or ramp, coldest quarter first.
    quarters, branches, holds, runs : the same error by one of them alone; keys as in a table.
    cycles : by run and by cycle within it.
    most : the smallest interval that holds at least the share `CompareOptions.most` of the error.
    """

    conditions: tuple[ConditionShare, ...]
    quarters: Mapping[str, Share]
    branches: Mapping[str, Share]
    holds: Mapping[str, Share]
    runs: Mapping[str, Share]
    cycles: Mapping[str, Mapping[int, Share]]
    most: Interval


def error_shares(
    members: Sequence[tuple[str, OperatingConditions, Floats]], options: CompareOptions = CompareOptions()
) -> ErrorShares:
    """Shares over all members: name of a run, its operating conditions (n,), its residual (n,)."""
    temperature = np.concatenate([r.temperature_c for _, r, _ in members])
    heating = np.concatenate([r.heating for _, r, _ in members])
    hold = np.concatenate([r.hold for _, r, _ in members])
    cycle = np.concatenate([r.cycle for _, r, _ in members])
    run = np.repeat(np.arange(len(members)), [e.size for _, _, e in members])
    squared = np.concatenate([e for _, _, e in members]) ** 2
    low, high = float(temperature.min()), float(temperature.max())
    edges = np.linspace(low, high, 5) if high > low else low + np.linspace(-0.5, 0.5, 5)
    ends = _told_apart(edges)
    quarter = np.clip(np.searchsorted(edges, temperature, side="right") - 1, 0, 3)

    def share(here: Flags) -> tuple[float, float, float]:
        part, total = float(np.sum(squared[here])), float(np.sum(squared))
        rms = float(np.sqrt(np.mean(squared[here]))) if here.any() else float("nan")
        return part / total if total > 0.0 else 0.0, float(np.mean(here)), rms

    return ErrorShares(
        conditions=tuple(
            ConditionShare(
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
        quarters={f"{ends[q]}–{ends[q + 1]} °C": Share(*share(quarter == q)) for q in range(4)},
        branches={branch: Share(*share(heating == (branch == "heating"))) for branch in BRANCHES},
        holds={"ramp": Share(*share(~hold)), "hold": Share(*share(hold))},
        runs={name: Share(*share(run == i)) for i, (name, _, _) in enumerate(members)},
        cycles={
            name: {int(n): Share(*share((run == i) & (cycle == n))) for n in np.unique(r.cycle)}
            for i, (name, r, _) in enumerate(members)
        },
        most=_most(temperature, heating, hold, squared, options),
    )


def _told_apart(edges: Floats) -> list[str]:
    """Temperatures with as few decimals as tell them apart."""
    texts: list[str] = []
    for decimals in range(MOST_DECIMALS + 1):
        texts = [f"{edge:.{decimals}f}" for edge in edges]
        if len(set(texts)) == len(texts):
            break
    return texts


def _most(temperature: Floats, heating: Flags, hold: Flags, squared: Floats, options: CompareOptions) -> Interval:
    """The smallest interval, by its samples, that holds most of the squared error.

    Tried from the simplest description (a range of temperatures) to the most particular (… on one branch, while held);
    a more particular one must be smaller by the factor ``options.simpler``.
    """
    steps = options.intervals
    edges = np.linspace(float(temperature.min()), float(temperature.max()), steps + 1)
    step = np.clip(np.searchsorted(edges, temperature, side="right") - 1, 0, steps - 1)
    total = float(np.sum(squared)) or 1.0
    best: Interval | None = None
    for branch, held, here in _descriptions(heating, hold):
        error = np.asarray(np.bincount(step[here], weights=squared[here], minlength=steps), dtype=np.float64)
        shortest = _shortest_interval(error, np.bincount(step[here], minlength=steps), total, options.most)
        if shortest is None:
            continue
        samples, share, begin, end = shortest
        if best is None or samples < options.simpler * best.sample_share * squared.size:
            rms = float(np.sqrt(share * total / max(samples, 1)))
            lower, upper = float(edges[begin]), float(edges[end])
            best = Interval(share, float(samples / squared.size), rms, branch, held, lower, upper)
    # Without any error there is no such interval.
    return best or Interval(0.0, 1.0, 0.0, None, None, float(edges[0]), float(edges[-1]))


def _shortest_interval(
    error: Floats, count: NDArray[np.intp], total: float, most: float
) -> tuple[int, float, int, int] | None:
    """Of all intervals of steps that hold the share ``most`` of the error, that with the fewest samples.

    ``error`` (steps,) is the squared error in each step, ``count`` (steps,) its samples, ``total`` the squared error of
    all data. Returns samples, share of the error, first step and step behind the last; None if all steps together hold
    less.
    """
    error_before = np.concatenate([[0.0], np.cumsum(error)]) / total
    count_before = np.concatenate([[0], np.cumsum(count)])
    enough = [
        (int(count_before[end] - count_before[begin]), begin, end)
        for begin in range(count.size)
        for end in range(begin + 1, count.size + 1)
        if error_before[end] - error_before[begin] >= most
    ]
    if not enough:
        return None
    samples, begin, end = min(enough)
    return samples, float(error_before[end] - error_before[begin]), begin, end


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
