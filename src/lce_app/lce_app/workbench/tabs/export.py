# SPDX-License-Identifier: Apache-2.0
"""Files to take away, and the commands that do what the page did."""

from __future__ import annotations

import asyncio
from pathlib import Path

from nicegui import ui

from lce_app.workbench import command_lines
from lce_app.workbench.bench import Workbench
from lce_report import render_comparison


def fill(bench: Workbench) -> None:
    """Downloads of the current model and of its reports, and command lines to copy. (CSV and PNG: at every figure.)"""
    number = bench.session.current
    if number is None:
        ui.label("There is no model yet.")
        return
    place = bench.session.place
    with ui.row().classes("line"):
        _download("Model (YAML)", bench.session.model_file(number))
        if bench.used():
            report = ui.button("Report: where it fails (HTML)").props("outline no-caps").mark("report")
            report.on_click(lambda: _report(bench))
        for label, file in (
            ("Report: what is missing (HTML)", bench.session.diagnosis_file(number).with_suffix(".html")),
            ("Diagnosis (JSON)", bench.session.diagnosis_file(number)),
            ("Report: the effect added (HTML)", bench.session.model_file(number).with_suffix(".html")),
        ):
            if file.exists():
                _download(label, file)
    ui.label("CSV (of the range in view) and PNG are at every figure.")
    ui.html("<h2>The same on the command line</h2>", sanitize=False)
    ui.label(f"In the folder {bench.folder}; the files of the page are in {place.name}/.")
    for line in commands(bench):
        with ui.row().classes("line command"):
            ui.html(f"<code>{line.replace('&', '&amp;').replace('<', '&lt;')}</code>", sanitize=False)
            ui.button("Copy", on_click=lambda line=line: ui.clipboard.write(line)).props("flat dense no-caps")


def commands(bench: Workbench) -> list[str]:
    """What the page shows, how the current model came about, and the waveforms designed, as commands."""
    number = bench.session.current
    assert number is not None
    model = bench.session.model_file(number)
    lines = [command_lines.compare(bench, model), command_lines.diagnose(bench, model)]
    if command := bench.session.kept(number).command:
        lines.append(command)
    return lines + [design["command"] for _, design in bench.designs()]


def _download(label: str, file: Path) -> None:
    ui.button(label, on_click=lambda: ui.download.content(file.read_bytes(), file.name)).props("outline no-caps")


async def _report(bench: Workbench) -> None:
    comparison = await asyncio.to_thread(bench.comparison)
    if comparison is not None:
        text = await asyncio.to_thread(render_comparison, comparison)
        ui.download.content(text, "compare.html")
