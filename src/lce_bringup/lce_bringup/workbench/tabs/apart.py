# SPDX-License-Identifier: Apache-2.0
"""The experiment that would tell two effects apart: designed, shown, and handed to the bench."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

import numpy as np
from nicegui import ui

from lce_bringup.workbench import drawings, work
from lce_bringup.workbench.bench import Workbench
from lce_bringup.workbench.figures import Figures
from lce_bringup.workbench.memory import turn_to
from lce_bringup.workbench.tabs.bench import run_simulated
from lce_bringup.workbench.telling import telling
from lce_model.effects import library

TELLING: Final = 5.0
"""Standard deviations that make a difference plain."""


def fill(bench: Workbench) -> None:
    """The two effects, the limits, and the waveforms designed so far."""
    number = bench.session.current
    if number is None:
        ui.label("A model is needed. Fit one on the tab Add.")
        return
    ui.label("The waveform, within the limits, after which two effects that look alike are told apart best.")
    first, second = likely_pair(bench)
    with ui.row().classes("line"):
        one = ui.select(list(library()), value=first, label="Effect")
        other = ui.select(list(library()), value=second, label="Looks like")
        power = ui.number("Laser at most [W]", value=2.0, min=0.05, max=2.0, step=0.1)
        hottest = ui.number("Strip at most [°C]", value=110.0, min=30.0, max=180.0, step=5.0)
        longest = ui.number("Longest [s]", value=150.0, min=30.0, max=600.0, step=10.0)

        def design() -> None:
            between = str(one.value), str(other.value)
            bench.start(
                f"Tell {between[0]} from {between[1]}",
                work.design,
                measure="separation",
                model=bench.session.model_file(number),
                between=between,
                power_w=float(power.value),
                temperature_c=float(hottest.value),
                duration_s=float(longest.value),
                out=bench.session.place / f"wave-{between[0]}-{between[1]}.csv",
            )

        ui.button("Design", color="accent", on_click=telling(design)).props("unelevated no-caps").mark("design")
    for file in sorted(bench.session.place.glob("wave-*.json")):
        _designed(bench, file)


def likely_pair(bench: Workbench) -> tuple[str, str]:
    """The strongest candidate of the diagnosis and what it looks like; else the first two of the library."""
    for candidate in (bench.diagnosis() or {"candidates": []})["candidates"]:
        if candidate["aliases"]:
            return candidate["effect"], candidate["aliases"][0]
    first, second, *_ = library()
    return first, second


def _designed(bench: Workbench, file: Path) -> None:
    about = json.loads(file.read_text(encoding="utf-8"))
    time_s, power_w = np.loadtxt(file.with_suffix(".csv"), delimiter=",", skiprows=1, unpack=True)
    one, other = about["between"]
    enough = "" if about["separation"] > TELLING else " Too little to tell them apart: give more time, power or heat."
    ui.html(f"<h2>{one} or {other}</h2>", sanitize=False)
    ui.label(
        f"{about['protocol']}: {time_s[-1]:.0f} s, {power_w.max():.2f} W and {about['hottest_c']:.0f} °C at most. "
        f"After the rival is refitted, {about['separation']:.1f} standard deviations of the noise remain.{enough}"
    )
    Figures(lambda: drawings.wave(f"{one} or {other}", time_s, power_w))
    wave = file.with_suffix(".csv").relative_to(bench.folder).as_posix()

    def run() -> None:
        run_simulated(bench, wave)
        turn_to("Bench")

    with ui.row().classes("line"):
        ui.button("Run it on the simulated bench", on_click=telling(run)).props("outline no-caps").mark(f"run {wave}")
        ui.label(f"Another strip, or the real bench: on the tab Bench, with the protocol {wave}")
