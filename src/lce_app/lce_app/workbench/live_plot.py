# SPDX-License-Identifier: Apache-2.0
"""A live plot on the page: curves that move along with the time, a y axis for each unit, and markers."""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from nicegui import ui

from lce_app.workbench.live_layout import Plot
from lce_app.workbench.topic_monitor import TopicMonitor

PALETTE: Final = ("model", "residual", "after", "input", "before", "heating", "measured", "quiet")
"""Colours of the style sheet, in the order of the series."""


class LivePlot(ui.element, component="live_plot.js"):
    """The curves of a plot. They are drawn while the tab is shown; ``on_zoom`` is called when the user zooms."""

    def __init__(self, plot: Plot, window_s: float, on_zoom: Callable[[], None]) -> None:
        super().__init__()
        self._series, self._counts = plot.series, [0] * len(plot.series)
        self._marked = 0
        self._drawn = False
        self.is_empty = True
        described = [
            {"label": s.name, "unit": s.unit.symbol, "colour": PALETTE[i % len(PALETTE)]}
            for i, s in enumerate(plot.series)
        ]
        self._props.update({"name": plot.name, "series": described, "height": plot.height, "span": window_s})
        self.on("ready", self._begin)
        self.on("gone", self._end)
        self.on("zoomed", lambda: on_zoom())

    def resize(self, height: int) -> None:
        """Take another height [px]."""
        self._props["height"] = height

    def _begin(self) -> None:
        """It is drawn anew and holds nothing."""
        self._counts, self._marked = [0] * len(self._series), 0
        self._drawn = self.is_empty = True

    def _end(self) -> None:
        self._drawn = False

    def follow(self, monitor: TopicMonitor, now_s: float) -> None:
        """Show what came since the last time; the axis ends at ``now_s`` of the node's clock [s]."""
        if not self._drawn:
            return
        self.is_empty = False
        batches = [self._batch(i, monitor) for i in range(len(self._series))]
        new = monitor.marker_count - self._marked
        markers = list(monitor.markers)[-new:] if new else []
        self._marked = monitor.marker_count
        told = [[marker.time_s - monitor.began_s, marker.text] for marker in markers]
        self.run_method("extend", batches, told, now_s - monitor.began_s)

    def _batch(self, i: int, monitor: TopicMonitor) -> list[str] | None:
        """The new times and values of a series, coded; None if nothing is new."""
        series = self._series[i]
        history = monitor.histories.get(series)
        if history is None or history.count == self._counts[i]:
            return None
        seen = self._counts[i] if self._counts[i] < history.count else 0  # a forgotten history begins anew
        times, values = history.since(seen)
        self._counts[i] = history.count
        drawn = series.unit.from_si(values.astype(np.float64))
        return [_coded((times - monitor.began_s).astype("<f8")), _coded(np.asarray(drawn).astype("<f4"))]


def _coded(values: np.ndarray[Any, Any]) -> str:
    return base64.b64encode(values.tobytes()).decode()
