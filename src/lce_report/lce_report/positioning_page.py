# SPDX-License-Identifier: Apache-2.0
"""Positioning experiments as a page: the four panels of Figs. 6.6 to 6.10 for each target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lce_data import __version__
from lce_report import Axis, Curve, Grid, Lines, Section, Table, render

if TYPE_CHECKING:
    from lce_experiment.positioning.outcome import Positioning

HEAD = ("target [mm]", "rise to 80 % [s]", "its limit [s]", "overshoot", "settling in 2 % [s]", "RMSE after 30 s",
        "energy [J]")  # fmt: skip
TIME = Axis("time", "s")


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


def page(mode: str, runs: Sequence[Positioning], about: Sequence[str]) -> str:
    """The HTML of all runs; ``about`` goes into the footer."""
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
    return render(f"lce control, {mode}", answer, sections, (*about, f"Written by lce {__version__}."))


def _panels(run: Positioning) -> Grid:
    """Displacement and target, temperature and setpoint, power, error in percent."""
    linked, target_mm = run.folder.name, 1e3 * run.target_m
    time_s, measured_m = run.series["displacement"]
    camera_s, temperature_c = run.series["temperature"]
    power_s, power_w = run.series["laser/power"]
    temperatures = [Curve("measured", temperature_c, "measured")]
    if "temperature_setpoint" in run.series:
        setpoint_s, setpoint_c = run.series["temperature_setpoint"]
        latest = np.clip(np.searchsorted(setpoint_s, camera_s, side="right") - 1, 0, None)
        temperatures.append(Curve("setpoint", setpoint_c[latest], "model", "dashed"))
    target = Curve("target", np.where(time_s < 0.0, np.nan, target_mm), "model", "dashed")
    error = np.where(time_s < 0.0, np.nan, 100.0 * (target_mm - 1e3 * measured_m) / target_mm)
    return Grid(
        (
            Lines("displacement and target", TIME, Axis("d", "mm"), time_s,
                  (Curve("measured", 1e3 * measured_m, "measured"), target), linked),
            Lines("temperature and setpoint", TIME, Axis("T", "°C"), camera_s, temperatures, linked),
            Lines("laser power", TIME, Axis("P", "W"), power_s, (Curve("P", power_w, "input", "step"),), linked),
            Lines("error, in percent of the target", TIME, Axis("error", "%"), time_s,
                  (Curve("error", error, "residual"),), linked),
        ),
        (1, 1),
    )  # fmt: skip


def _seconds(time_s: float) -> str:
    return "never" if np.isnan(time_s) else f"{time_s:.2f}"
