# SPDX-License-Identifier: Apache-2.0
"""Which runs there are, which are learnt from and which held out, and which files are none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from nicegui import ui

from lce_app.workbench.bench import Entry, Workbench

if TYPE_CHECKING:
    from lce_data.run import Run, Series

ROLES: Final = {"train": "learn from", "test": "hold out", "off": "leave aside"}
WIDE, HIGH, POINTS = 120, 34, 120


def fill(bench: Workbench) -> None:
    """The files of the folder as a table."""
    ui.button("Read the folder anew", on_click=bench.reopen).props("flat dense no-caps").classes("as-wide").mark("anew")
    if not bench.entries:
        ui.label("No bag, MCAP file or CSV in this folder. Record one on the tab Bench, or with lce run.")
        return
    with ui.element("table").classes("runs"):
        with ui.element("thead"), ui.element("tr"):
            for head in ("run", "conditions", "measured", "temperature, displacement", "use"):
                with ui.element("th").props("scope=col"):
                    ui.label(head)
        with ui.element("tbody"):
            for name, entry in bench.entries.items():
                _row(bench, name, entry)


def _row(bench: Workbench, name: str, entry: Entry) -> None:
    with ui.element("tr").mark(f"run {name}"):
        with ui.element("th").props("scope=row"):
            ui.label(name)
        if entry.error:
            with ui.element("td").props("colspan=4").classes("bad"):
                ui.label(f"cannot be used: {entry.error}")
            return
        with ui.element("td"):
            ui.label(conditions(entry.run) if entry.run else "not read")
        with ui.element("td").classes("measured"):
            for line in _measured(entry.run) if entry.run else ():
                ui.label(line)
        with ui.element("td"):
            if entry.run:
                ui.html(_thumbnail(entry.run), sanitize=False)
        with ui.element("td"):
            role = ui.radio(ROLES, value=bench.session.roles[name]).props(f'inline dense aria-label="use of {name}"')
            role.on_value_change(lambda event: bench.set_role(name, event.value))


def conditions(run: Run) -> str:
    """What was done, on what, in a few words."""
    about = run.conditions
    words = [str(about["protocol"])] if about.get("protocol") else []
    nested = about.get("conditions")
    for key, value in (nested if isinstance(nested, dict) else {}).items():
        name, _, unit = str(key).rpartition("_")
        words.append(f"{name.replace('_', ' ')} {value:g} {'°C' if unit == 'c' else unit}")
    if about.get("outcome") not in (None, "complete"):
        words.append(str(about["outcome"]))
    return " · ".join(words)


def _measured(run: Run) -> list[str]:
    """What was measured how often, and for how long."""
    series = {"P": run.power, "T": run.temperature, "d": run.displacement}
    there = {name: s for name, s in series.items() if s is not None}
    length = max(s.time_s[-1] for s in there.values())
    rates = {name: 1.0 / float(np.median(np.diff(s.time_s))) for name, s in there.items()}
    return [f"{length:.0f} s", *(f"{name} at {rate:.3g} Hz" for name, rate in rates.items())]


def _thumbnail(run: Run) -> str:
    drawn = [("model", run.temperature), ("residual", run.displacement)]
    lines = "".join(_line(series, role) for role, series in drawn if series is not None)
    about = f"temperature and displacement of {run.name} over time".replace('"', "").replace("<", "")
    return (
        f'<svg viewBox="0 0 {WIDE} {HIGH}" width="{WIDE}" height="{HIGH}" role="img" aria-label="{about}">{lines}</svg>'
    )


def _line(series: Series, role: str) -> str:
    keep = np.linspace(0, series.time_s.size - 1, POINTS).astype(int)
    x, y = series.time_s[keep], series.value[keep]
    across = (x - x[0]) / ((x[-1] - x[0]) or 1.0) * WIDE
    down = HIGH - 2.0 - (y - y.min()) / (np.ptp(y) or 1.0) * (HIGH - 4.0)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))
    return f'<polyline points="{points}" fill="none" stroke="var(--{role})" stroke-width="1.2"/>'
