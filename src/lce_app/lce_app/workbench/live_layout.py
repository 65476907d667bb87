# SPDX-License-Identifier: Apache-2.0
"""Which live plots there are, in which order and of which size: a plain value, kept in ``workbench/bench.yaml``.

The same file remembers the conditions that were stated for the last recording.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, Literal

from msgspec import Struct, to_builtins

from lce_app.workbench.live_series import WANTED, Series, series_of
from lce_app.workbench.session import NAME
from lce_data.channels import POWER, SENSORS
from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.given_conditions import check_conditions
from lce_data.schema import checked, read_yaml
from lce_data.yaml_text import dump
from lce_experiment.registry import NAMESPACE

FILE_NAME: Final = "bench.yaml"
WINDOWS_S: Final = (10.0, 30.0, 60.0, 300.0)
"""Lengths of time [s] that the plots can show."""
HEIGHTS_PX: Final = (120, 170, 240, 340, 480)
MOST_PLOTS: Final = 24
MOST_SERIES: Final = 8
"""Of one plot: the colours of more would look alike."""
FORGOTTEN: Final = ("notes", "day")
"""Conditions that belong to one recording only."""


@dataclass(frozen=True)
class Plot:
    """A live plot: what it shows, its height [px], and whether it is as wide as the page or half of it.

    ``key`` tells it from the others of a layout wherever it is moved.
    """

    series: tuple[Series, ...]
    height: int = 170
    wide: bool = False
    key: int = 0

    @property
    def name(self) -> str:
        """How lists and screen readers call it."""
        return ", ".join(series.name for series in self.series)


def _default_plots() -> tuple[Plot, ...]:
    """One for each channel of the bench, with what is wanted of it."""
    plots = []
    for key, channel in enumerate((*SENSORS, POWER)):
        own = series_of(channel)
        wanted = (Series(f"{NAMESPACE}/{WANTED[channel][0]}", own.path),) if channel in WANTED else ()
        plots.append(Plot((own, *wanted), wide=channel is POWER, key=key))
    return tuple(plots)


@dataclass(frozen=True)
class Layout:
    """The plots in their order, and the length of time that they show [s]."""

    plots: tuple[Plot, ...] = field(default_factory=_default_plots)
    window_s: float = 60.0

    @property
    def series(self) -> frozenset[Series]:
        """All that is shown."""
        return frozenset(series for plot in self.plots for series in plot.series)

    def plot(self, key: int) -> Plot | None:
        """The plot of a key, None if it was removed."""
        return next((plot for plot in self.plots if plot.key == key), None)

    def with_plot(self, series: tuple[Series, ...]) -> Layout:
        """One plot more, at the end. Raises LceError if there are too many, or the plot would show nothing."""
        if len(self.plots) >= MOST_PLOTS:
            raise LceError(f"{MOST_PLOTS} plots are the most; remove one first")
        return replace(self, plots=(*self.plots, Plot(_few(series), key=self._next_key())))

    def with_series(self, key: int, series: tuple[Series, ...]) -> Layout:
        """Another plot in the place of one, as large. Raises LceError if it would show nothing, or too much."""
        return self._with(key, series=_few(series), key=self._next_key())

    def without(self, key: int) -> Layout:
        """One plot less."""
        return replace(self, plots=tuple(plot for plot in self.plots if plot.key != key))

    def showing(self, window_s: float) -> Layout:
        """Another length of time [s]."""
        return replace(self, window_s=window_s)

    def moved(self, key: int, steps: int) -> Layout:
        """A plot so many places later, or for negative steps earlier, as far as there are places."""
        plot = self.plot(key)
        if plot is None:
            return self
        others = [other for other in self.plots if other.key != key]
        others.insert(max(self.plots.index(plot) + steps, 0), plot)
        return replace(self, plots=tuple(others))

    def placed(self, key: int, there: int) -> Layout:
        """A plot moved to where another one is."""
        plot, other = self.plot(key), self.plot(there)
        if plot is None or other is None:
            return self
        return self.moved(key, self.plots.index(other) - self.plots.index(plot))

    def resized(self, key: int, steps: int) -> Layout:
        """A plot that is higher, or for negative steps lower."""
        plot = self.plot(key)
        at = HEIGHTS_PX.index(plot.height) + steps if plot is not None else 0
        return self._with(key, height=HEIGHTS_PX[min(max(at, 0), len(HEIGHTS_PX) - 1)])

    def widened(self, key: int) -> Layout:
        """A plot of half the page made as wide as the page, or back."""
        plot = self.plot(key)
        return self._with(key, wide=plot is not None and not plot.wide)

    def _with(self, key_of: int, /, **changes: Any) -> Layout:
        return replace(self, plots=tuple(replace(p, **changes) if p.key == key_of else p for p in self.plots))

    def _next_key(self) -> int:
        return 1 + max((plot.key for plot in self.plots), default=0)


class PlotEntry(Struct, frozen=True):
    """A plot in the file."""

    series: list[tuple[str, str]]
    height: int = 170
    wide: bool = False


class LiveFile(Struct, frozen=True):
    """The content of ``bench.yaml``: plots by their series (topic, path), and the conditions of the last recording."""

    format: Literal["lce-bench-1"]
    window_s: float
    plots: list[PlotEntry]
    conditions: dict[str, Any] = {}


class LiveView:
    """The layout that all pages share, the conditions of the last recording, and the pages that look.

    version : counts the changes of the layout. error : why the file could not be read, "" if it could.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / NAME / FILE_NAME
        self.layout, self.conditions, self.version, self.error = Layout(), dict[str, Any](), 0, ""
        self.viewers: set[object] = set()
        if self._file.exists():
            try:
                self.layout, self.conditions = _read(self._file)
            except LceError as error:
                self.error = f"{error}; the plots are the usual ones"

    @property
    def watched(self) -> frozenset[Series]:
        """What has to be received: nothing while no page is open."""
        return self.layout.series if self.viewers else frozenset()

    def change(self, layout: Layout) -> None:
        """Take another layout, and keep it. Raises LceError if the folder cannot be written."""
        self.layout, self.error = layout, ""
        self.version += 1
        self._save()

    def remember(self, conditions: Mapping[str, Any]) -> None:
        """Keep what was stated for a recording, but for what belongs to that one only."""
        self.conditions = {key: value for key, value in conditions.items() if key not in FORGOTTEN}
        self._save()

    def _save(self) -> None:
        plots = [PlotEntry([(s.topic, s.path) for s in p.series], p.height, p.wide) for p in self.layout.plots]
        content = LiveFile("lce-bench-1", self.layout.window_s, plots, self.conditions)
        try:
            self._file.parent.mkdir(exist_ok=True)
        except OSError as error:
            raise LceError(f"{self._file.parent}: cannot be made ({error.strerror})") from None
        write_atomically(self._file, dump(to_builtins(content)))


def _read(file: Path) -> tuple[Layout, dict[str, Any]]:
    """Layout and conditions of a file. Raises LceError that names the file, the key and the value."""
    content = checked(file, read_yaml(file), LiveFile)
    plots = tuple(
        Plot(
            tuple(Series(topic, path) for topic, path in entry.series[:MOST_SERIES]), _height(entry.height), entry.wide
        )
        for entry in content.plots[:MOST_PLOTS]
        if entry.series
    )
    window_s = min(WINDOWS_S, key=lambda s: abs(s - content.window_s))
    return Layout(plots, window_s), check_conditions(content.conditions)


def _height(height: int) -> int:
    """The height that there is next to one of a file [px]."""
    return min(HEIGHTS_PX, key=lambda known: abs(known - height))


def _few(series: tuple[Series, ...]) -> tuple[Series, ...]:
    if not series:
        raise LceError("choose a topic first")
    if len(series) > MOST_SERIES:
        raise LceError(f"{len(series)} topics in one plot; it shows {MOST_SERIES} at most")
    return tuple(dict.fromkeys(series))
