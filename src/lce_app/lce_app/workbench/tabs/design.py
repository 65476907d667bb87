# SPDX-License-Identifier: Apache-2.0
"""The experiment that tells two effects apart: designed, shown, and handed to the bench."""

from __future__ import annotations

from pathlib import Path

from nicegui import ui

from lce_analysis.options import DesignOptions
from lce_app.workbench import command_lines, drawings, tasks
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.figures import Figures
from lce_app.workbench.memory import turn_to
from lce_app.workbench.records import DesignRecord
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.suggestions import pair_to_tell_apart
from lce_app.workbench.tabs.bench import run_simulated
from lce_app.workbench.texts import heading
from lce_data.errors import LceError
from lce_data.units import KELVIN
from lce_data.wave_file import read_wave
from lce_experiment.config import laser_limit_w
from lce_model.effects import library


def fill(state: WorkbenchState) -> None:
    """The two effects, the limits, and the waveforms designed so far."""
    number = state.session.current
    if number is None:
        ui.label("A model is needed. Fit one on the tab Add.")
        return
    ui.label("The waveform within the limits that separates two similar effects best.")
    first, second = pair_to_tell_apart(state)
    usual, laser_w = DesignOptions(), laser_limit_w()
    usual_c = usual.max_temperature_k - KELVIN
    with ui.row().classes("line"):
        one = ui.select(list(library()), value=first, label="Effect")
        other = ui.select(list(library()), value=second, label="Looks like")
        power_w = ui.number("Laser at most [W]", value=min(usual.max_power_w, laser_w), min=0.05, max=laser_w, step=0.1)
        hottest_c = ui.number("Strip at most [°C]", value=usual_c, min=30.0, max=180.0, step=5.0)
        longest_s = ui.number("Longest [s]", value=usual.duration_s, min=30.0, max=600.0, step=10.0)

        def begin() -> None:
            limits = _number(power_w), _number(hottest_c), _number(longest_s)
            design(state, number, (str(one.value), str(other.value)), limits)

        ui.button("Design", color="accent", on_click=notify_errors(begin)).props("unelevated no-caps").mark("design")
    for file, about in state.designs():
        _designed(state, file, about)


def design(state: WorkbenchState, number: int, between: tuple[str, str], limits: tuple[float, float, float]) -> None:
    """Begin the search for a waveform within limits of power [W], temperature [°C] and duration [s]."""
    model = state.session.model_file(number)
    state.start(
        f"Tell {between[0]} from {between[1]}",
        tasks.design,
        measure="separation",
        model=model,
        between=between,
        limits=limits,
        command=command_lines.design(state, model, between, limits),
        out=state.session.place / f"wave-{between[0]}-{between[1]}.csv",
    )


def _number(field: ui.number) -> float:
    if field.value is None:
        raise LceError(f"{field.props['label']}: a number is needed")
    return float(field.value)


def _designed(state: WorkbenchState, file: Path, about: DesignRecord) -> None:
    """A waveform, what it is worth, and the button that runs it."""
    time_s, power_w = read_wave(file)
    one, other = about.between
    heading(f"{one} or {other}")
    ui.label(" ".join(about.sentences or (about.protocol,)))
    Figures(lambda: drawings.wave(f"{one} or {other}", time_s, power_w))
    wave = file.relative_to(state.folder).as_posix()

    def run() -> None:
        run_simulated(state, wave)
        turn_to("Bench")

    with ui.row().classes("line"):
        ui.button("Run it on the simulated bench", on_click=notify_errors(run)).props("outline no-caps").mark(
            f"run {wave}"
        )
        ui.label(f"Another strip, or the real bench: on the tab Bench, with the protocol {wave}")
