# SPDX-License-Identifier: Apache-2.0
"""The runs of the folder: which are learnt from, which are held out, and which files cannot be used."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from lce_app.workbench.colours import colour
from lce_app.workbench.entries import RunEntry
from lce_app.workbench.session import Role
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import named
from lce_data.channels import SENSORS
from lce_data.experiment_file import content_of

if TYPE_CHECKING:
    from lce_data.run import Run, Series

ROLES: Final = {"train": "learn from", "test": "hold out", "off": "leave aside"}
UNITS: Final = {"m": "m", "c": "°C", "n": "N"}
"""Units by the suffix of a condition's name."""
WIDE, HIGH, POINTS = 120, 34, 120


def fill(state: WorkbenchState) -> Callable[[], None]:
    """The tab, and what brings it up to date."""
    return RunsTab(state).follow


class RunsTab:
    """The files of the folder as a table; ``follow`` draws a row anew only if its file was read, or has gone.

    What is drawn anew loses the click that comes meanwhile, so the choice of a run's use stays when its file is read.
    """

    def __init__(self, state: WorkbenchState) -> None:
        self._state = state
        self._shown: dict[str, tuple[RunEntry, ui.element]] = {}
        self._uses: dict[str, ui.radio] = {}
        self._cells: dict[str, tuple[ui.element, ...]] = {}
        ui.button("Read the folder anew", on_click=state.reopen).props("flat dense no-caps").classes("as-wide").mark(
            "anew"
        )
        self._none = ui.label("No bag, MCAP file or CSV in this folder. Record one on the tab Bench, or with lce run.")
        with ui.element("table").classes("runs") as self._table:
            with ui.element("thead"), ui.element("tr"):
                for head in ("run", "conditions", "measured"):
                    _head(head)
                with _head(""):
                    for channel in SENSORS:
                        with ui.element("div"):
                            ui.element("span").classes("key").style(f"background: var(--{colour(channel)})")
                            ui.label(channel.name)
                _head("use")
            self._body = ui.element("tbody")
        self.follow()

    def follow(self) -> None:
        """Show the runs as they are now."""
        entries = self._state.entries
        if list(entries) != list(self._shown):
            self._body.clear()
            self._shown, self._uses = {}, {}
        for name, entry in entries.items():
            if name not in self._shown or self._shown[name][0] is not entry:
                self._show(name, entry)
        for name, use in self._uses.items():
            use.set_value(self._state.session.roles[name])
        self._none.visible, self._table.visible = not entries, bool(entries)

    def _show(self, name: str, entry: RunEntry) -> None:
        if name in self._shown:
            row = self._shown[name][1]
            if name in self._uses and not entry.error:
                self._shown[name] = entry, row
                self._describe(name, entry)
                return
            row.clear()
        else:
            with self._body:
                row = ui.element("tr").mark(f"run {name}")
        self._shown[name] = entry, row
        self._uses.pop(name, None)
        with row:
            with ui.element("th").props("scope=row"):
                ui.label(name)
            if entry.error:
                with ui.element("td").props("colspan=4"):
                    ui.label(f"cannot be used: {entry.error}").classes("bad")
                    if entry.recording is not None:
                        ui.label("The tab Prepare can add what it lacks from another file.").classes("quiet")
            else:
                self._fill(name, entry)

    def _fill(self, name: str, entry: RunEntry) -> None:
        """The cells of a run that can be used."""
        self._cells[name] = ui.element("td"), ui.element("td").classes("measured"), ui.element("td")
        self._describe(name, entry)
        with ui.element("td"):
            use = ui.radio(ROLES, value=self._state.session.roles[name]).props("inline dense")
            named(use, f"use of {name}")
            use.on_value_change(partial(self._choose, name))
            self._uses[name] = use

    def _describe(self, name: str, entry: RunEntry) -> None:
        """What the run is, what was measured, and its picture."""
        about, sensors, picture = self._cells[name]
        for cell in self._cells[name]:
            cell.clear()
        with about:
            ui.label(conditions(entry.run) if entry.run else "not read")
            if entry.recipe:
                ui.label(f"prepared: {'; '.join(step.words for step in entry.recipe)}").classes("quiet")
            for warning in entry.warnings:
                ui.label(warning).classes("bad")
        with sensors:
            for line in measured(entry.run) if entry.run else ():
                ui.label(line)
        with picture:
            if entry.run:
                _thumbnail(entry.run)

    def _choose(self, name: str, event: ValueChangeEventArguments[Role]) -> Awaitable[None]:
        """Take the choice at once, before ``follow`` looks; read the run when there is time."""
        self._state.set_role(name, event.value)
        return self._state.read_used()


def _head(text: str) -> ui.element:
    with ui.element("th").props("scope=col") as cell:
        if text:
            ui.label(text)
    return cell


def conditions(run: Run) -> str:
    """What was done, on what, in a few words."""
    about = run.experiment
    words = [about.protocol] if about.protocol else []
    words += [_condition(key, value) for key, value in content_of(about.conditions).items()]
    if about.outcome not in (None, "complete"):
        words.append(str(about.outcome))
    return " · ".join(words)


def _condition(key: str, value: Any) -> str:
    """`strip_length_m`, 0.01 as "strip length 0.01 m"."""
    name, _, suffix = key.rpartition("_")
    unit = UNITS.get(suffix)
    number = f"{value:g}" if isinstance(value, int | float) else str(value)
    return f"{(name if unit else key).replace('_', ' ')} {number} {unit or ''}".rstrip()


def measured(run: Run) -> list[str]:
    """What was measured how often, and for how long."""
    length_s = max(series.time_s[-1] for series in run.series.values())
    often = [f"{channel.symbol} {_how_often(series)}" for channel, series in run.series.items()]
    return [f"{length_s:.0f} s", *often]


def _how_often(series: Series) -> str:
    if series.time_s.size < 2:
        return "once"
    return f"at {1.0 / float(np.median(np.diff(series.time_s))):.3g} Hz"


def _thumbnail(run: Run) -> None:
    names = " and ".join(channel.name for channel in run.measured)
    picture = named(ui.element("svg"), f"{names} of {run.name} over time")
    picture.props.update({"viewBox": f"0 0 {WIDE} {HIGH}", "width": WIDE, "height": HIGH, "role": "img"})
    with picture:
        for channel, series in run.measured.items():
            stroke = {"fill": "none", "stroke": f"var(--{colour(channel)})", "stroke-width": 1.2}
            ui.element("polyline").props.update({"points": _points(series), **stroke})


def _points(series: Series) -> str:
    """The series as points of a polyline."""
    keep = np.linspace(0, series.time_s.size - 1, POINTS).astype(int)
    x, y = series.time_s[keep], series.value[keep]
    across = (x - x[0]) / ((x[-1] - x[0]) or 1.0) * WIDE
    down = HIGH - 2.0 - (y - y.min()) / (np.ptp(y) or 1.0) * (HIGH - 4.0)
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))
