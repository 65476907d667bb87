# SPDX-License-Identifier: Apache-2.0
"""Files to take away, and the commands that do what the page did."""

from __future__ import annotations

import asyncio
import shlex
from collections.abc import Sequence
from pathlib import Path

from nicegui import ui

from lce_analysis.report import render_comparison
from lce_bringup.workbench.bench import Workbench


def fill(bench: Workbench) -> None:
    """Downloads of the current model and of its reports, and command lines to copy. (CSV and PNG: at every figure.)"""
    number = bench.session.current
    if number is None:
        ui.label("There is no model yet.")
        return
    place = bench.session.place
    with ui.row().classes("line"):
        _download("Model (YAML)", bench.session.model_file(number))
        if bench.runs("train") | bench.runs("test"):
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
    for line in command_lines(bench):
        with ui.row().classes("line command"):
            ui.html(f"<code>{line.replace('&', '&amp;').replace('<', '&lt;')}</code>", sanitize=False)
            ui.button("Copy", on_click=lambda line=line: ui.clipboard.write(line)).props("flat dense no-caps")


def command_lines(bench: Workbench) -> list[str]:
    """What the page shows and last did, as commands."""
    number = bench.session.current
    assert number is not None

    def relative(paths: Sequence[Path]) -> list[str]:
        return [path.relative_to(bench.folder).as_posix() for path in paths]

    (model,) = relative([bench.session.model_file(number)])
    train, test = relative(bench.paths("train")), relative(bench.paths("test"))
    held_out = ["--test", *test] if test else []
    lines = [
        ["lce", "compare", *train, *test, "--model", model, "--report", "compare.html"],
        ["lce", "diagnose", *train, *held_out, "--model", model, "--report", "diagnose.html"],
    ]
    kept = bench.session.kept(number)
    if kept.parent is not None and kept.how.endswith(f"added to model {kept.parent}"):
        effect, (parent,) = kept.how.split()[0], relative([bench.session.model_file(kept.parent)])
        lines.append(["lce", "add", effect, *train, *held_out, "--model", parent, "--out", "model.yaml"])
    if kept.how.endswith(" fitted"):
        thermal, _, deformation, _ = kept.how.split()
        lines.append(["lce", "fit", *train, "--thermal", thermal, "--deformation", deformation, "--out", "model.yaml"])
    return [shlex.join(words) for words in lines]


def _download(label: str, file: Path) -> None:
    ui.button(label, on_click=lambda: ui.download.content(file.read_bytes(), file.name)).props("outline no-caps")


async def _report(bench: Workbench) -> None:
    comparison = await asyncio.to_thread(bench.comparison)
    if comparison is not None:
        text = await asyncio.to_thread(render_comparison, comparison)
        ui.download.content(text, "compare.html")
