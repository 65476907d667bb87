# SPDX-License-Identifier: Apache-2.0
"""The steps of a recipe: plain values that check themselves, each turning a run into another one.

Times are those of the run as the steps before have left it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Final, Literal

import numpy as np
from msgspec import Meta, Struct

from lce_data.channels import POWER, SENSORS, TEMPERATURE, Channel, channel_named, in_order
from lce_data.errors import LceError, did_you_mean
from lce_data.preparing.sampling import Interval, at, behind, held_means, means, median_step, within
from lce_data.run import Run, Series

MOST_SAMPLES: Final = 10_000_000
LATEST_S: Final = 1e7
"""A merged file begins so many seconds before or after the run at most: some months."""


class Cut(Struct, frozen=True, forbid_unknown_fields=True, tag_field="step", tag="cut"):
    """Leave out the sensors' samples from ``begin_s`` to ``end_s``, both included.

    The strip remembers what came before, so the laser power and the optional inputs stay: a model needs them to get
    over the interval. Only a cut of all sensors that leaves none behind it drops them, too.

    channels : names of sensors; all if empty.
    """

    begin_s: float
    end_s: float
    channels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_interval((self.begin_s, self.end_s))
        for name in self.channels:
            _sensor(name)

    @property
    def words(self) -> str:
        """The step in words."""
        what = " and ".join(self.channels) or "all sensors"
        return f"cut {what} from {self.begin_s:g} to {self.end_s:g} s"

    def apply(self, run: Run, others: Mapping[str, Run]) -> Run:
        """The run without those samples. Raises LceError if no sample lies there, or no model could start."""
        chosen = [channel for channel in run.measured if not self.channels or channel.name in self.channels]
        kept = dict(run.series)
        for channel in chosen:
            series = run.series[channel]
            kept[channel] = at(series, ~within(series.time_s, [(self.begin_s, self.end_s)]))
        if all(kept[channel].time_s.size == run.series[channel].time_s.size for channel in chosen):
            raise LceError("no sample lies there")
        left = {channel: series for channel, series in kept.items() if series.time_s.size}
        _check_start(run, left)
        last = max((left[channel].time_s[-1] for channel in left if channel in SENSORS), default=-math.inf)
        if last < self.begin_s and len(chosen) == len(run.measured):
            left = {channel: at(series, series.time_s <= last) for channel, series in left.items()}
        return _with(run, {channel: series for channel, series in left.items() if series.time_s.size})

    def warnings(self, run: Run) -> tuple[str, ...]:
        """What a user should know of this step on a run."""
        if run.power is None and (not self.channels or TEMPERATURE.name in self.channels):
            return ("without a laser power the temperature drives the model: it is straight across the cut",)
        return ()


class Detrend(Struct, frozen=True, forbid_unknown_fields=True, tag_field="step", tag="detrend"):
    """Take an offset or a straight line off a sensor, fitted while the strip is at rest.

    order : ``offset`` shifts the sensor; ``line`` takes a drift off, too.
    rest : intervals [s] at rest; the whole run if empty.
    level : what the sensor should show at rest [recorded unit]. A line without it keeps the level with which the
        first interval begins.
    """

    channel: str
    order: Literal["offset", "line"]
    rest: tuple[Interval, ...] = ()
    level: float | None = None

    def __post_init__(self) -> None:
        _sensor(self.channel)
        for interval in self.rest:
            _check_interval(interval)
        if self.level is not None:
            _check_finite(self.level)
        elif self.order == "offset":
            raise LceError("an offset needs the level that the sensor should show at rest")

    @property
    def words(self) -> str:
        """The step in words."""
        what = "straight line" if self.order == "line" else "offset"
        where = ", ".join(f"{begin:g} to {end:g} s" for begin, end in self.rest)
        level = "" if self.level is None else f", to {self.level:g} {_sensor(self.channel).recorded.symbol}"
        return f"take a {what} off {self.channel}, fitted {f'at rest: {where}' if where else 'to the whole run'}{level}"

    def apply(self, run: Run, others: Mapping[str, Run]) -> Run:
        """The run with the sensor at its level. Raises LceError if it was not measured at rest."""
        channel = _sensor(self.channel)
        if channel not in run.series:
            raise LceError(f"the run has no {channel.name}")
        series = run.series[channel]
        here = within(series.time_s, self.rest) if self.rest else np.ones(series.time_s.size, dtype=np.bool_)
        order = 1 if self.order == "line" else 0
        if np.count_nonzero(here) <= order:
            raise LceError(
                f"{np.count_nonzero(here)} samples of {channel.name} are at rest there; mark a longer interval"
            )
        begin = series.time_s[here][0]
        line = np.polynomial.Polynomial.fit(series.time_s[here] - begin, series.value[here], order)
        level = line(0.0) if self.level is None else channel.recorded.to_si(self.level)
        return run.with_series(channel, Series(series.time_s, series.value - line(series.time_s - begin) + level))

    def warnings(self, run: Run) -> tuple[str, ...]:
        """What a user should know of this step on a run."""
        if self.order == "offset":
            return ()
        found = [
            f"a slow change of {self.channel} that belongs to the strip goes with the line: "
            "displacement_drift, ambient_drift and slow creep can no longer be found in it"
        ]
        series = run.series.get(_sensor(self.channel))
        if self.rest and series is not None:
            marked = max(end for _, end in self.rest) - min(begin for begin, _ in self.rest)
            if marked < 0.5 * float(np.ptp(series.time_s)):
                found.append("the line is drawn far beyond the intervals at rest; mark one at either end of the run")
        return tuple(found)


class Resample(Struct, frozen=True, forbid_unknown_fields=True, tag_field="step", tag="resample"):
    """Means over intervals of ``dt_s``, so that no fast noise is folded into slow changes.

    The laser power, which is held from sample to sample, keeps its energy. A channel that was recorded as slowly as
    that, or slower, stays as it is.
    """

    dt_s: Annotated[float, Meta(gt=0.0)]

    def __post_init__(self) -> None:
        _check_finite(self.dt_s)

    @property
    def words(self) -> str:
        """The step in words."""
        return f"means over {self.dt_s:g} s"

    def apply(self, run: Run, others: Mapping[str, Run]) -> Run:
        """The run with fewer samples. Raises LceError if no channel was recorded faster."""
        fast = [channel for channel, series in run.series.items() if median_step(series) < 0.999 * self.dt_s]
        if not fast:
            finest = min(map(median_step, run.series.values()))
            raise LceError(f"no channel was recorded faster than every {finest:g} s")
        end_s = max(series.time_s[-1] for series in run.series.values())
        if run.power is not None and end_s / self.dt_s > MOST_SAMPLES:
            raise LceError(f"that makes {end_s / self.dt_s:.3g} samples, {MOST_SAMPLES} at most")
        fewer = {
            c: held_means(run.series[c], self.dt_s, end_s) if c is POWER else means(run.series[c], self.dt_s)
            for c in fast
        }
        return _with(run, {**run.series, **fewer})

    def warnings(self, run: Run) -> tuple[str, ...]:
        """What a user should know of this step on a run."""
        return ()


class Merge(Struct, frozen=True, forbid_unknown_fields=True, tag_field="step", tag="merge"):
    """Add what another file holds: other channels of the same experiment, or the same ones later.

    file : path from the folder of the run.
    at_s : time of this run at which the other one begins (its first sample of the laser power, or of any channel if it
        has no power).
    """

    file: str
    at_s: Annotated[float, Meta(ge=-LATEST_S, le=LATEST_S)] = 0.0

    def __post_init__(self) -> None:
        _check_finite(self.at_s)
        if not self.file:
            raise LceError("a merge needs a file")

    @property
    def words(self) -> str:
        """The step in words."""
        return f"add {self.file} from {self.at_s:g} s on"

    def apply(self, run: Run, others: Mapping[str, Run]) -> Run:
        """Both in one. Raises LceError if they hold the same channel at the same time, or are of different strips."""
        other = others[self.file]
        ours, theirs = run.strip_length_m, other.strip_length_m
        if None not in (ours, theirs) and ours != theirs:
            raise LceError(f"the strips are {ours:g} and {theirs:g} m long: not one experiment")
        joined = dict(run.series)
        for channel, series in other.series.items():
            later = Series(series.time_s + self.at_s, series.value)
            joined[channel] = behind(joined[channel], later, channel.name) if channel in joined else later
        timed = [joined[POWER]] if POWER in joined else joined.values()
        zero_s = min(series.time_s[0] for series in timed)
        marked = (*run.markers, *(replace(m, time_s=m.time_s + self.at_s) for m in other.markers))
        markers = sorted((replace(m, time_s=m.time_s - zero_s) for m in marked), key=lambda m: m.time_s)
        shifted = {c: Series(series.time_s - zero_s, series.value) for c, series in joined.items()}
        return replace(_with(run, shifted), markers=tuple(markers))

    def warnings(self, run: Run) -> tuple[str, ...]:
        """What a user should know of this step on a run."""
        return ()


def _with(run: Run, series: Mapping[Channel, Series]) -> Run:
    return replace(run, series={channel: series[channel] for channel in in_order(series)})


def _sensor(name: str) -> Channel:
    """The sensor of a name. Raises LceError if there is none."""
    names = [channel.name for channel in SENSORS]
    if name not in names:
        raise LceError(f"{name!r} is no sensor{did_you_mean(name, names)}; there are {' and '.join(names)}")
    return channel_named(name)


def _check_finite(number: float) -> None:
    if not math.isfinite(number):
        raise LceError(f"{number} is not a finite number")


def _check_interval(interval: Interval) -> None:
    begin, end = interval
    for time_s in interval:
        _check_finite(time_s)
    if begin >= end:
        raise LceError(f"the interval from {begin:g} to {end:g} s ends before it begins")


def _check_start(run: Run, left: Mapping[Channel, Series]) -> None:
    """Raise LceError if the temperatures that tell a model where it starts are among what was cut."""
    before, after = run.temperature, left.get(TEMPERATURE)
    if before is None or after is None or run.power is None or after.time_s[0] == before.time_s[0]:
        return
    on = run.power.time_s[run.power.value > 0.0]
    if on.size and after.time_s[0] > on[0]:
        first_s = max(before.time_s[0], on[0])
        raise LceError(f"a model starts with the temperature before the light; begin the cut after {first_s:g} s")
