# SPDX-License-Identifier: Apache-2.0
"""One experiment as plain values: a series for each channel that was measured, in SI units."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import DISPLACEMENT, INPUTS, POWER, SENSORS, TEMPERATURE, Channel, channel_of_column, in_order
from lce_data.experiment_file import Experiment
from lce_data.marker import Marker

if TYPE_CHECKING:
    import polars

Floats = NDArray[np.float64]

MICROSECONDS: Final = 6
"""Decimals of the times of a table: channels of a bag that differ by less share a row."""


@dataclass(frozen=True)
class Series:
    """One measured quantity: time [s], increasing, and value [SI unit of its channel], both (n,) and finite."""

    time_s: Floats
    value: Floats


@dataclass(frozen=True)
class Run:
    """One experiment. Time zero is the first sample of the laser power, or of any channel if no power was recorded.

    Parameters
    ----------
    name : tells the run from others in reports: the name of its file or folder.
    series : what was measured, by channel; the laser power is held from sample to sample, an optional input is straight
        between its samples.
    path : file or folder that it was read from; empty for a run made in code.
    sha256 : identifies the data.
    experiment : what ``experiment.yaml`` says of the run; empty for a CSV.
    markers : what was marked while it was recorded, by time; none for a CSV.

    Examples
    --------
    >>> time_s = np.arange(0.0, 10.0, 0.1)
    >>> warm = Series(time_s, np.full(100, 310.0))
    >>> run = Run.of("warm", power=Series(time_s, np.ones(100)), temperature=warm)
    >>> list(run.measured), run.displacement is None
    ([<channel temperature [K]>], True)
    """

    name: str
    series: Mapping[Channel, Series]
    path: Path = Path()
    sha256: str = ""
    experiment: Experiment = field(default_factory=Experiment)
    markers: tuple[Marker, ...] = ()

    @classmethod
    def of(
        cls,
        name: str,
        power: Series | None = None,
        temperature: Series | None = None,
        displacement: Series | None = None,
        sha256: str = "",
    ) -> "Run":
        """Make a run of the bench's own three channels; None for a channel that was not measured."""
        given = {POWER: power, TEMPERATURE: temperature, DISPLACEMENT: displacement}
        return cls(name, {channel: series for channel, series in given.items() if series is not None}, sha256=sha256)

    def with_series(self, channel: Channel, series: Series | None) -> "Run":
        """The same run with another series of a channel, or without it if None."""
        others = {c: s for c, s in self.series.items() if c is not channel}
        return replace(self, series=others if series is None else others | {channel: series})

    def aligned(self) -> tuple[Floats, dict[Channel, Floats]]:
        """The samples of all channels on one time axis.

        Returns
        -------
        time_s : (n,)
        values : (n,) of each channel [its SI unit], NaN where it has no sample.
        """
        rounded: dict[int, Floats] = {}  # channels of a table share their times
        for series in self.series.values():
            if id(series.time_s) not in rounded:
                rounded[id(series.time_s)] = np.round(series.time_s, MICROSECONDS)
        time_s = max(rounded.values(), key=len)
        for others in rounded.values():
            at = np.minimum(np.searchsorted(time_s, others), time_s.size - 1)
            if (time_s[at] != others).any():
                time_s = np.union1d(time_s, others)
        values = {}
        for channel, series in self.series.items():
            values[channel] = series.value
            if series.value.size != time_s.size:
                values[channel] = np.full(time_s.size, np.nan)
                values[channel][np.searchsorted(time_s, rounded[id(series.time_s)])] = series.value
        return time_s, values

    def to_dataframe(self) -> "polars.DataFrame":
        """The run as a table: ``time_s`` and a column for each channel, named and in the unit as in a CSV of the bench.

        A cell is null where the channel has no sample. ``.to_pandas()`` makes a pandas table of it, where pandas and
        pyarrow are installed.

        Examples
        --------
        >>> time_s = np.arange(3.0)
        >>> run = Run.of("warm", power=Series(time_s, np.ones(3)), temperature=Series(time_s[1:], np.full(2, 293.15)))
        >>> run.to_dataframe().rows()[:2]
        [(0.0, 1.0, None), (1.0, 1.0, 20.0)]
        """
        import polars

        time_s, values = self.aligned()
        columns = {c.column: c.recorded.from_si(values[c]) for c in in_order(values)}
        return polars.DataFrame({"time_s": time_s, **columns}, nan_to_null=True)

    @property
    def power(self) -> Series | None:
        """The laser power [W], None if it was not recorded."""
        return self.series.get(POWER)

    @property
    def temperature(self) -> Series | None:
        """The temperature [K], None if it was not measured."""
        return self.series.get(TEMPERATURE)

    @property
    def displacement(self) -> Series | None:
        """The displacement [m], None if it was not measured."""
        return self.series.get(DISPLACEMENT)

    @property
    def measured(self) -> Mapping[Channel, Series]:
        """The sensors' series, in the order of the channels."""
        return {channel: self.series[channel] for channel in SENSORS if channel in self.series}

    @property
    def inputs(self) -> Mapping[Channel, Series]:
        """The optional inputs: a series where one was measured, else one number where ``conditions`` give it."""
        given = self.experiment.conditions
        known = {*INPUTS, *self.series, *map(channel_of_column, given.other)}
        found = dict[Channel, Series]()
        for channel in in_order(c for c in known if c is not None and c.sets):
            if channel in self.series:
                found[channel] = self.series[channel]
            elif (value := given.value(channel)) is not None:
                found[channel] = Series(np.zeros(1), np.array([channel.recorded.to_si(value)]))
        return found

    @property
    def strip_length_m(self) -> float | None:
        """Length of the strip, None if the recording does not say it."""
        return self.experiment.conditions.strip_length_m
