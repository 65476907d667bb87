# SPDX-License-Identifier: Apache-2.0
"""A run cut, detrended, resampled or merged by a recipe, drawn beside the recording, which stays as it is."""

from __future__ import annotations

import os
from collections.abc import Awaitable, Callable, Sequence
from typing import Final

from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from lce_app.workbench import drawings
from lce_app.workbench.entries import RunEntry
from lce_app.workbench.error_notification import notify_errors_of
from lce_app.workbench.figures import Figures
from lce_app.workbench.memory import remember, remembered
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import heading, named
from lce_data.channels import SENSORS, channel_named
from lce_data.errors import LceError
from lce_data.preparing.recipe import Step
from lce_data.preparing.sampling import Interval
from lce_data.preparing.steps import Cut, Detrend, Merge, Resample
from lce_report import Block

KEY: Final = "prepared run"
ALL: Final = "all sensors"
NAMES: Final = tuple(channel.name for channel in SENSORS)
ORDERS: Final = {"line": "a straight line", "offset": "an offset"}
DRAGS: Final = {"mark": "marks an interval", "zoom": "zooms"}


def fill(state: WorkbenchState) -> Callable[[], None]:
    """The tab, and what brings it up to date."""
    return PrepareTab(state).follow


class PrepareTab:
    """The tab of one page. The interval, and those at rest, are the page's; the recipe is the session's."""

    def __init__(self, state: WorkbenchState) -> None:
        self._state = state
        self._rest: tuple[Interval, ...] = ()
        self._drawn: RunEntry | None = None
        ui.label(
            "Everything on this page uses the run as the steps prepare it; the recording stays as it is. Drag over a "
            "figure, or type the interval."
        )
        with ui.row().classes("line"):
            self._chosen = ui.select([], label="Run").classes("protocol").mark("prepared")
            self._chosen.on_value_change(self._choose)
            ui.label("Dragging")
            drag = named(ui.radio(DRAGS, value="mark").props("inline dense"), "dragging over a figure")
            drag.on_value_change(self._drag)
            self._begin = _number("From [s]", None).mark("begin")
            self._end = _number("To [s]", None).mark("end")
            for field in (self._begin, self._end):
                field.on_value_change(self._light)
        self._cut_controls()
        self._detrend_controls()
        self._resample_controls()
        self._merge_controls()
        heading("Steps")
        self._steps = ui.element("div").props("tabindex=-1").mark("steps")
        self._removed: int | None = None
        self._figures = Figures(self._blocks, on_mark=self._mark).mark("preparation")
        self._figures.marking(True)
        self._tell_rest()
        self.follow()

    def _cut_controls(self) -> None:
        with _row("Cut"):
            channels = ui.select([ALL, *NAMES], value=ALL, label="Sensors")

            def step() -> Step:
                return Cut(*self._interval(), () if channels.value == ALL else (str(channels.value),))

            self._button("Leave the interval out", step).mark("cut")
            ui.label("The laser power stays: the strip remembers it.").classes("quiet")

    def _detrend_controls(self) -> None:
        with _row("Detrend"):
            order = ui.select(ORDERS, value="line", label="Take off")
            channel = ui.select(list(NAMES), value=NAMES[-1], label="Sensor")
            level = ui.number().mark("level")
            ui.button("The interval is at rest", on_click=notify_errors_of(self._add_rest)).props(
                "outline no-caps"
            ).mark("rest")
            ui.button("Clear", on_click=self._clear_rest).props('flat no-caps aria-label="clear the intervals at rest"')

            def follow_unit() -> None:
                level.props["label"] = f"Level at rest [{channel_named(str(channel.value)).display.symbol}]"

            channel.on_value_change(follow_unit)
            follow_unit()

            def step() -> Step:
                shown, found = level.value, channel_named(str(channel.value))
                value = None if shown is None else found.recorded.from_si(found.display.to_si(float(shown)))
                return Detrend(found.name, order.value or "line", self._rest, value)

            self._button("Take it off", step).mark("detrend")
            self._rest_told = ui.label().classes("quiet").mark("rests")

    def _resample_controls(self) -> None:
        with _row("Resample"):
            dt = _number("Means over [s]", 0.1).mark("dt")
            self._button("Resample", lambda: Resample(_value(dt))).mark("resample")
            ui.label("The laser power keeps its energy.").classes("quiet")

    def _merge_controls(self) -> None:
        with _row("Merge"):
            self._other = ui.select([], label="File").mark("other")
            at = _number("It begins at [s]", 0.0).mark("at")

            def step() -> Step:
                if not self._other.value:
                    raise LceError("choose the file to add")
                return Merge(self._from_run(str(self._other.value)), _value(at))

            self._button("Add its channels", step).mark("merge")
            self._ends = ui.label().classes("quiet")

    def _button(self, text: str, step: Callable[[], Step]) -> ui.button:
        """A button that appends a step to the recipe of the run."""

        async def add() -> None:
            name = self._name
            await self._state.prepare(name, (*self._state.session.recipe(name), step()))

        return ui.button(text, on_click=notify_errors_of(add)).props("outline no-caps")

    @property
    def _name(self) -> str:
        """The run chosen. Raises LceError if there is none."""
        if not self._chosen.value:
            raise LceError("choose a run")
        return str(self._chosen.value)

    def _entry(self) -> RunEntry | None:
        return self._state.entries.get(str(self._chosen.value))

    def _from_run(self, name: str) -> str:
        """A file of the folder, as a recipe names it: from the folder of the run."""
        entries = self._state.entries
        return os.path.relpath(entries[name].path, entries[self._name].path.parent)

    def _interval(self) -> Interval:
        """The interval. Raises LceError if its end is not after its beginning."""
        begin, end = _value(self._begin), _value(self._end)
        if begin >= end:
            raise LceError(f"the interval from {begin:g} to {end:g} s ends before it begins")
        return begin, end

    def _drag(self, event: ValueChangeEventArguments[str]) -> None:
        self._figures.marking(event.value == "mark")

    def _mark(self, begin: float, end: float) -> None:
        self._begin.value, self._end.value = round(begin, 3), round(end, 3)

    async def _add_rest(self) -> None:
        self._rest = (*self._rest, self._interval())
        self._tell_rest()

    def _clear_rest(self) -> None:
        self._rest = ()
        self._tell_rest()

    def _tell_rest(self) -> None:
        told = ", ".join(f"{begin:g} to {end:g} s" for begin, end in self._rest)
        self._rest_told.text = (
            f"fitted at rest: {told}" if told else "fitted to the whole run, unless intervals are at rest"
        )
        self._light()

    def _light(self) -> None:
        """Show the interval and those at rest in the figures."""
        entry, spans = self._entry(), list(self._rest)
        begin, end = self._begin.value, self._end.value
        if begin is not None and end is not None and begin < end:
            spans.append((begin, end))
        if entry is not None and entry.recording is not None:
            self._figures.light({drawings.marked_on(entry.recording): spans})

    async def _choose(self, event: ValueChangeEventArguments[str]) -> None:
        remember(KEY, event)
        self._clear_rest()
        if event.value:
            await self._state.read(event.value)

    def follow(self) -> None:
        """Show the runs that there are, and the steps and figures of the one chosen when they have changed."""
        entries = self._state.entries
        names = [name for name, entry in entries.items() if not entry.error]
        names += [name for name, entry in entries.items() if entry.error and entry.recording is not None]
        if names != self._chosen.options:
            self._chosen.set_options(names, value=remembered(KEY, names) if names else None)
        entry = self._entry()
        if entry is self._drawn or entry is None:
            return
        self._drawn = entry
        run = entry.run or entry.recording
        self._ends.text = f"This run ends at {max(s.time_s[-1] for s in run.series.values()):g} s." if run else ""
        self._other.set_options([name for name in entries if name != self._chosen.value])
        self._show_steps(entry)
        self._figures.reload()
        self._light()

    def _show_steps(self, entry: RunEntry) -> None:
        """The recipe, a line for each step, and what there is to say of it."""
        self._steps.clear()
        next_focus = self._steps
        with self._steps:
            if not entry.recipe:
                ui.label("None: the run is used as it was recorded.")
            with ui.element("ol").classes("recipe"):
                for number, step in enumerate(entry.recipe):
                    with ui.element("li"):
                        ui.label(step.words)
                        remove = ui.button("Remove", on_click=self._removing(number)).props("flat dense no-caps")
                        named(remove, f"Remove step {number + 1}").mark(f"remove-step-{number + 1}")
                        if self._removed is not None and number <= self._removed:
                            next_focus = remove
            for text in (*entry.warnings, *([f"cannot be used: {entry.error}"] if entry.error else [])):
                ui.label(text).classes("bad")
        if self._removed is not None:  # the button that had the focus is gone
            next_focus.run_method("focus")
            self._removed = None

    def _removing(self, number: int) -> Callable[[], Awaitable[None]]:
        async def remove() -> None:
            self._removed = number
            await self._state.remove_step(str(self._chosen.value), number)

        return notify_errors_of(remove)

    def _blocks(self) -> Sequence[Block]:
        entry = self._entry()
        return [] if entry is None or entry.recording is None else drawings.preparation(entry.recording, entry.run)


def _row(text: str) -> ui.row:
    with ui.row().classes("line") as row:
        ui.label(text).classes("what")
    return row


def _number(label: str, value: float | None) -> ui.number:
    return ui.number(label, value=value).classes("short")


def _value(field: ui.number) -> float:
    if field.value is None:
        raise LceError(f"{field.props['label']}: a number is needed")
    return float(field.value)
