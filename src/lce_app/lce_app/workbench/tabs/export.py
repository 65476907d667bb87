# SPDX-License-Identifier: Apache-2.0
"""Files to export, and the commands that do what the page did."""

from __future__ import annotations

import asyncio
from pathlib import Path
from tempfile import TemporaryDirectory

from nicegui import ui

from lce_app.workbench import archive, command_lines
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import code, heading
from lce_data.errors import LceError
from lce_report.pages.comparison import render_comparison


def fill(state: WorkbenchState) -> None:
    """Downloads of the current model and of its reports, and command lines to copy. (CSV and PNG: at every figure.)"""
    number = state.session.current
    if number is None:
        ui.label("There is no model yet.")
        return
    place = state.session.place
    with ui.row().classes("line"):
        _download("Model (YAML)", state.session.model_file(number))
        if state.used():
            report = ui.button("Report: where it fails (HTML)").props("outline no-caps").mark("report")
            report.on_click(lambda: _report(state))
        for label, file in (
            ("Report: what is missing (HTML)", state.session.diagnosis_file(number).with_suffix(".html")),
            ("Diagnosis (JSON)", state.session.diagnosis_file(number)),
            ("Report: what no library holds (HTML)", state.session.discovery_file(number).with_suffix(".html")),
            ("Discovery (JSON)", state.session.discovery_file(number)),
            ("Report: the effect added (HTML)", state.session.model_file(number).with_suffix(".html")),
        ):
            if file.exists():
                _download(label, file)
        everything = ui.button("Everything (ZIP)").props("outline no-caps").mark("everything")
        everything.on_click(lambda: _everything(state))
        ui.label("the runs in use, models, reports and versions: on another machine, lce workbench FILE.zip opens it")
    ui.label("CSV, PNG, SVG and PDF (of the range in view) are at every figure.")
    heading("The same on the command line")
    ui.label(f"In the folder {state.folder}; the files of the page are in {place.name}/.")
    for line in commands(state):
        with ui.row().classes("line command"):
            code(line)
            ui.button("Copy", on_click=lambda line=line: ui.clipboard.write(line)).props("flat dense no-caps")


def commands(state: WorkbenchState) -> list[str]:
    """What the page shows, how the current model came about, and the waveforms designed, as commands."""
    number = state.session.current
    assert number is not None
    model = state.session.model_file(number)
    lines = [*command_lines.prepare(state), command_lines.compare(state, model), command_lines.diagnose(state, model)]
    if state.session.discovery_file(number).exists():
        lines.append(command_lines.discover(state, model))
    if command := state.session.kept(number).command:
        lines.append(command)
    return lines + [design.command for _, design in state.designs()]


def _download(label: str, file: Path) -> None:
    ui.button(label, on_click=lambda: ui.download.content(file.read_bytes(), file.name)).props("outline no-caps")


async def _everything(state: WorkbenchState) -> None:
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{state.folder.name}.zip"
        try:
            await asyncio.to_thread(archive.write, state.session, state.recordings(), file)
        except LceError as error:
            ui.notify(str(error), type="negative")
            return
        ui.download.content(await asyncio.to_thread(file.read_bytes), file.name)


async def _report(state: WorkbenchState) -> None:
    comparison = await asyncio.to_thread(state.comparison)
    if comparison is not None:
        text = await asyncio.to_thread(render_comparison, comparison)
        ui.download.content(text, "compare.html")
