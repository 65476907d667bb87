# SPDX-License-Identifier: Apache-2.0
"""The live plots on the tab Bench: any number of them, any topics, paused or following, and markers."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Final

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.live_layout import WINDOWS_S, Layout, Plot
from lce_app.workbench.live_plot import LivePlot
from lce_app.workbench.live_series import Series, recorded_series
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import named
from lce_data.marker import one_line

WINDOWS: Final = {s: f"{s:g} s" if s < 120.0 else f"{s / 60.0:g} min" for s in WINDOWS_S}


class MarkerKey(ui.element, component="marker_key.js"):
    """The key M."""


@dataclass(frozen=True)
class Card:
    """A plot on the page: its frame with the tools, its curves, and the length of time that they show [s]."""

    frame: ui.element
    curves: LivePlot
    window_s: float

    def show(self, plot: Plot) -> None:
        """Take the size of the plot."""
        self.frame.classes(add="wide" if plot.wide else "", remove="" if plot.wide else "wide")
        self.curves.resize(plot.height)


class LivePanel:
    """The plots of one page; ``follow`` brings them up to date. Their layout is that of all pages."""

    def __init__(self, state: WorkbenchState) -> None:
        self._state, self._live = state, state.live
        self._shown = -1
        self._cards: dict[int, Card] = {}
        self._paused, self._now_s = False, 0.0
        self._chosen_for: int | None = None
        self._dragged: int | None = None
        self._begun_s: float | None = None
        self._marker_row()
        with ui.row().classes("line"):
            self._pause = ui.button("Pause", on_click=lambda: self._set_paused(not self._paused))
            self._pause.props("outline no-caps").mark("pause")
            self._window = named(ui.select(WINDOWS, value=state.live.layout.window_s, label="Shows the last"), "window")
            self._window.on_value_change(self._take_window)
            ui.button("Add a plot", on_click=lambda: self._choose(None)).props("outline no-caps").mark("add plot")
        self._error = ui.label(state.live.error).classes("bad")
        self._topic_row()
        self._place = ui.element("div").classes("live-plots")
        MarkerKey().on("pressed", self._press)
        client = ui.context.client
        state.live.viewers.add(client.id)
        client.on_delete(lambda: state.live.viewers.discard(client.id))

    def follow(self) -> None:
        """Show the layout if it has changed, and what came since the last time."""
        monitor = self._state.monitor
        if self._shown != self._live.version:
            self._shown = self._live.version
            self._fill()
        if not monitor.snapshots:
            return
        if not self._paused or not self._now_s:
            self._now_s = monitor.snapshots[-1].time_s
        for card in self._cards.values():
            if not self._paused or card.curves.is_empty:
                card.curves.follow(monitor, self._now_s)

    # Plots

    def _fill(self) -> None:
        """Bring the plots into the present order; those that stay keep what they show."""
        layout = self._live.layout
        self._error.text, self._error.visible = self._live.error, bool(self._live.error)
        self._window.set_value(layout.window_s)
        gone = [
            key for key, card in self._cards.items() if layout.plot(key) is None or card.window_s != layout.window_s
        ]
        for key in gone:
            self._cards.pop(key).frame.delete()
        for place, plot in enumerate(layout.plots):
            if plot.key not in self._cards:
                with self._place:
                    self._cards[plot.key] = self._card(plot)
            card = self._cards[plot.key]
            card.show(plot)
            card.frame.move(target_index=place)

    def _card(self, plot: Plot) -> Card:
        key, window_s = plot.key, self._live.layout.window_s
        with ui.element("figure").classes("live").mark(f"plot {plot.name}") as frame:
            with ui.element("figcaption") as caption:
                ui.label(plot.name)
                with ui.element("span").classes("tools"):
                    self._tool("topics", f"choose topics: {plot.name}", partial(self._choose, key))
                    for sign, what, change in (
                        ("↔", "wide or half as wide", Layout.widened),
                        ("+", "higher", partial(Layout.resized, steps=1)),
                        ("−", "lower", partial(Layout.resized, steps=-1)),
                        ("↑", "move up", partial(Layout.moved, steps=-1)),
                        ("↓", "move down", partial(Layout.moved, steps=1)),
                        ("×", "remove", Layout.without),
                    ):
                        self._tool(sign, f"{what}: {plot.name}", partial(self._change_plot, change, key))
            curves = LivePlot(plot, window_s, partial(self._set_paused, True))
        caption.props["draggable"] = "true"
        caption.on("dragstart", partial(self._drag, key), args=[])
        caption.on("dragend", partial(self._drag, None), args=[])
        frame.on("drop", notify_errors(partial(self._drop, key)), args=[])
        return Card(frame, curves, window_s)

    def _tool(self, sign: str, name: str, act: Callable[[], object]) -> None:
        button = ui.element("button").classes("take").on("click", notify_errors(act)).mark(name)
        button.props["type"] = "button"
        named(button, name)
        button.props["title"] = name.partition(":")[0]
        with button:
            ui.label(sign)

    def _drag(self, key: int | None) -> None:
        self._dragged = key

    def _drop(self, there: int) -> None:
        """Put the plot that is dragged where another one is; files are dropped on plots as well."""
        key, self._dragged = self._dragged, None
        if key is not None:
            self._change(lambda layout: layout.placed(key, there))

    def _change_plot(self, change: Callable[[Layout, int], Layout], key: int) -> None:
        self._change(lambda layout: change(layout, key))

    def _change(self, change: Callable[[Layout], Layout]) -> None:
        self._live.change(change(self._live.layout))

    def _take_window(self, event: ValueChangeEventArguments[float]) -> None:
        if event.value != self._live.layout.window_s:
            notify_errors(lambda: self._change(lambda layout: layout.showing(event.value)))()

    def _set_paused(self, paused: bool) -> None:
        self._paused = paused
        self._pause.text = "Follow" if paused else "Pause"

    # Choice of topics

    def _topic_row(self) -> None:
        """The list of topics, in line: Esc would close a dialog, and stop the bench as well."""
        with ui.row().classes("line") as self._row:
            self._series = ui.select({}, label="Topics of the plot", multiple=True, with_input=True)
            self._series.props("use-chips").classes("topics").mark("topics")
            self._take = ui.button("Show", color="accent", on_click=notify_errors(self._take_choice))
            self._take.props("unelevated no-caps").mark("take topics")
            ui.button("Close", on_click=lambda: self._row.set_visibility(False)).props("flat no-caps")
            ui.label("Type to search. What nobody publishes yet can be chosen, too.").classes("conditions")
        self._row.visible = False

    def _choose(self, key: int | None) -> None:
        """Show the list of topics. It stays while the user chooses: a new one would take back what is typed."""
        self._chosen_for = key
        plot = None if key is None else self._live.layout.plot(key)
        chosen = () if plot is None else plot.series
        self._take.text = "Add the plot" if plot is None else "Show in the plot"
        self._series.set_value([])
        self._series.set_options(topic_choices(self._state, chosen), value=list(chosen))
        self._row.visible = True

    def _take_choice(self) -> None:
        chosen, key = tuple(self._series.value or ()), self._chosen_for
        if key is None or self._live.layout.plot(key) is None:
            self._change(lambda layout: layout.with_plot(chosen))
        else:
            self._change(lambda layout: layout.with_series(key, chosen))
        self._row.visible = False

    # Markers

    def _marker_row(self) -> None:
        with ui.row().classes("line"):
            self._text = ui.input("Marker", placeholder="M, then what happened, then Enter").classes(
                "protocol marker-text"
            )
            self._text.mark("marker").props("maxlength=200")
            self._text.on_value_change(self._begin_marker)
            self._text.on("blur", self._leave_marker)
            self._text.on("keydown.enter", notify_errors(self._mark))
            ui.button("Mark", on_click=notify_errors(self._mark)).props("outline no-caps").mark("mark")
            ui.label("A marker has the time at which you began to type.").classes("conditions")

    def _press(self) -> None:
        """M begins a marker."""
        self._begun_s = time.monotonic()

    def _begin_marker(self, event: ValueChangeEventArguments[str | None]) -> None:
        if not event.value:
            self._begun_s = None
        elif self._begun_s is None:
            self._begun_s = time.monotonic()

    def _leave_marker(self) -> None:
        """What is not written has not begun."""
        if not self._text.value:
            self._begun_s = None

    def _mark(self) -> None:
        monitor = self._state.monitor
        text = one_line(str(self._text.value or "")) or f"mark {monitor.marker_count + 1}"
        age_s = 0.0 if self._begun_s is None else time.monotonic() - self._begun_s
        monitor.mark(text, age_s)
        self._text.set_value("")
        self._text.run_method("blur")
        self._begun_s = None
        where = "it is in the recording" if monitor.recording else "nothing is recorded now"
        ui.notify(f"marked: {text}; {where}")


def topic_choices(state: WorkbenchState, chosen: Iterable[Series]) -> dict[Series, str]:
    """Everything that can be plotted, and what is chosen already, by name and unit."""
    there = {series for topic in state.monitor.topics for series in topic.series}
    series = sorted({*recorded_series(), *there, *chosen}, key=lambda s: s.name)
    return {s: s.name if s.unit.symbol == "1" else f"{s.name} [{s.unit.symbol}]" for s in series}
