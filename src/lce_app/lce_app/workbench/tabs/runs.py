# SPDX-License-Identifier: Apache-2.0
"""The runs of the folder: which are learnt from, which are held out, and which files cannot be used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from nicegui import ui

from lce_app.workbench.colours import colour
from lce_app.workbench.state import RunEntry, WorkbenchState
from lce_app.workbench.texts import named
from lce_data.experiment_file import content_of

if TYPE_CHECKING:
    from lce_data.run import Run, Series

ROLES: Final = {"train": "learn from", "test": "hold out", "off": "leave aside"}
UNITS: Final = {"m": "m", "c": "°C", "n": "N"}
"""Units by the suffix of a condition's name."""
WIDE, HIGH, POINTS = 120, 34, 120


def fill(state: WorkbenchState) -> None:
    """The files of the folder as a table."""
    ui.button("Read the folder anew", on_click=state.reopen).props("flat dense no-caps").classes("as-wide").mark("anew")
    if not state.entries:
        ui.label("No bag, MCAP file or CSV in this folder. Record one on the tab Bench, or with lce run.")
        return
    with ui.element("table").classes("runs"):
        with ui.element("thead"), ui.element("tr"):
            for head in ("run", "conditions", "measured", "temperature, displacement", "use"):
                with ui.element("th").props("scope=col"):
                    ui.label(head)
        with ui.element("tbody"):
            for name, entry in state.entries.items():
                _row(state, name, entry)


def _row(state: WorkbenchState, name: str, entry: RunEntry) -> None:
    with ui.element("tr").mark(f"run {name}"):
        with ui.element("th").props("scope=row"):
            ui.label(name)
        if entry.error:
            with ui.element("td").props("colspan=4").classes("bad"):
                ui.label(f"cannot be used: {entry.error}")
            return
        with ui.element("td"):
            ui.label(conditions(entry.run) if entry.run else "not read")
            for warning in entry.warnings:
                ui.label(warning).classes("bad")
        with ui.element("td").classes("measured"):
            for line in measured(entry.run) if entry.run else ():
                ui.label(line)
        with ui.element("td"):
            if entry.run:
                _thumbnail(entry.run)
        with ui.element("td"):
            role = ui.radio(ROLES, value=state.session.roles[name]).props("inline dense")
            named(role, f"use of {name}")
            role.on_value_change(lambda event: state.set_role(name, event.value))


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
    rates = {channel.symbol: 1.0 / float(np.median(np.diff(s.time_s))) for channel, s in run.series.items()}
    return [f"{length_s:.0f} s", *(f"{symbol} at {rate:.3g} Hz" for symbol, rate in rates.items())]


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
