# SPDX-License-Identifier: Apache-2.0
"""The report of `lce control`: the four panels of Wu (2021), Figs. 6.6 to 6.10, for each target."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from lce_control.positioning import Positioning
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.topics import SETPOINT
from lce_report.blocks import Axis, Curve, Grid, Lines, Section, Table
from lce_report.figures.axes import TIME, displayed, value_axis
from lce_report.html.render import render
from lce_report.pages.footer import WRITTEN_BY

HEAD: Final = (
    "target [mm]",
    "rise to 80 % [s]",
    "its limit [s]",
    "overshoot",
    "settling in 2 % [s]",
    "RMSE after 30 s",
    "energy [J]",
)


def rows(runs: Sequence[Positioning]) -> list[tuple[str, ...]]:
    """The figures of each run as text, in the columns of ``HEAD``."""
    return [
        (
            f"{1e3 * run.target_m:g}",
            _seconds(run.figures.rise_time_s),
            _seconds(run.limit_rise_time_s),
            f"{run.figures.overshoot:.2%}",
            _seconds(run.figures.settling_time_s),
            "–" if np.isnan(run.figures.rmse_after_30s) else f"{run.figures.rmse_after_30s:.2%}",
            f"{run.energy_j:.1f}",
        )
        for run in runs
    ]


def render_positioning(mode: str, runs: Sequence[Positioning], about: Sequence[str]) -> str:
    """Positioning runs as one self-contained HTML file.

    Parameters
    ----------
    mode : which controllers: "double", "single" or "model".
    runs : one for each target.
    about : lines for the foot of the page.

    Returns
    -------
    str
        The text of the file.
    """
    worst = max(runs, key=lambda run: np.nan_to_num(run.figures.rmse_after_30s, nan=np.inf))
    answer = (
        f"Position control, mode {mode}: {', '.join(f'{1e3 * run.target_m:g}' for run in runs)} mm.",
        f"Largest RMSE after 30 s: {rows([worst])[0][5]} of the target, at {1e3 * worst.target_m:g} mm.",
    )
    notes = (
        "The limit is that of the same strip under full power until the switching time, everything known. On a "
        "simulated strip the figures are those of its true displacement, without the noise of the sensor."
    )
    sections = [Section("Figures", (Table("", HEAD, rows(runs)), notes))]
    sections += [Section(f"{1e3 * run.target_m:g} mm", (_panels(run),)) for run in runs]
    return render(f"lce control, {mode}", answer, sections, (*about, WRITTEN_BY))


def _panels(run: Positioning) -> Grid:
    """Displacement and target, temperature and setpoint, power, error in percent."""
    panels = (_displacement(run), _temperature(run), _power(run), _error(run))
    return Grid(panels, (1, 1))


def _displacement(run: Positioning) -> Lines:
    time_s, measured_m = run.series[DISPLACEMENT.topic]
    target = displayed(DISPLACEMENT, np.where(time_s < 0.0, np.nan, run.target_m))
    curves = (
        Curve("measured", displayed(DISPLACEMENT, measured_m), "measured"),
        Curve("target", target, "model", "dashed"),
    )
    return Lines("displacement and target", TIME, value_axis(DISPLACEMENT), time_s, curves, run.folder.name)


def _temperature(run: Positioning) -> Lines:
    time_s, measured_c = run.series[TEMPERATURE.topic]
    curves = [Curve("measured", displayed(TEMPERATURE, measured_c), "measured")]
    if SETPOINT in run.series:
        setpoint_s, setpoint_c = run.series[SETPOINT]
        latest = np.clip(np.searchsorted(setpoint_s, time_s, side="right") - 1, 0, None)
        curves.append(Curve("setpoint", displayed(TEMPERATURE, setpoint_c[latest]), "model", "dashed"))
    return Lines("temperature and setpoint", TIME, value_axis(TEMPERATURE), time_s, curves, run.folder.name)


def _power(run: Positioning) -> Lines:
    time_s, power_w = run.series[POWER.topic]
    curve = Curve(POWER.symbol, displayed(POWER, power_w), "input", "step")
    return Lines("laser power", TIME, value_axis(POWER), time_s, (curve,), run.folder.name)


def _error(run: Positioning) -> Lines:
    time_s, measured_m = run.series[DISPLACEMENT.topic]
    error = np.where(time_s < 0.0, np.nan, 100.0 * (run.target_m - measured_m) / run.target_m)
    curve = Curve("error", error, "residual")
    return Lines("error, in percent of the target", TIME, Axis("error", "%"), time_s, (curve,), run.folder.name)


def _seconds(time_s: float) -> str:
    return "never" if np.isnan(time_s) else f"{time_s:.2f}"
