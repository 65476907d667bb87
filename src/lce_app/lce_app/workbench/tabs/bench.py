# SPDX-License-Identifier: Apache-2.0
"""Run an experiment and see it live: values and curves from the topics, what the nodes say, and the stop button."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from nicegui import ui

from lce_app.workbench import drawings
from lce_app.workbench import tasks as work
from lce_app.workbench.bench import Workbench
from lce_app.workbench.error_notification import telling
from lce_app.workbench.figures import Figures
from lce_app.workbench.live import KEPT_S
from lce_data.errors import LceError
from lce_data.waveforms import SHAPES

LEVELS: Final = ("ok", "warning", "error")
ARMED: Final = "hardware"


def fill(bench: Workbench) -> Callable[[], None]:
    """The tab, and what brings it up to date."""
    return Bench(bench).follow


class Bench:
    """The tab; ``follow`` brings the live part up to date."""

    def __init__(self, bench: Workbench) -> None:
        self._bench, self._count, self._began_s = bench, bench.ear.count, 0.0
        self._told: dict[str, tuple[int, str]] = {}
        with ui.row().classes("line"):
            self._protocol = ui.input("Protocol", value="pulse:amp=0.4,th=20").classes("protocol").mark("protocol")
            self._model = ui.input("Simulated strip", placeholder="built in, or a model file").classes("protocol")
            self._settings = ui.input("Its parameters", placeholder="creep.share=0.1 …").classes("protocol")
        with ui.row().classes("line"):
            ui.button("Run on the simulated bench", color="accent", on_click=telling(self._run)).props(
                "unelevated no-caps"
            ).mark("start")
            self._hardware()
            ui.button("Stop: laser to zero", color="negative", on_click=bench.stop).props("unelevated no-caps").mark(
                "stop"
            )
        ui.label(
            f"Protocols: {', '.join(SHAPES)}, with options as for lce run, or a CSV file of this folder. Esc stops."
        )
        self._values = ui.label("nothing heard yet").classes("values").props("role=status").mark("values")
        self._conditions = ui.element("div").classes("conditions").mark("conditions")
        self._curves = Figures(drawings.live)

    def follow(self) -> None:
        """Show what was heard since the last time."""
        ear = self._bench.ear
        new, self._count = ear.since(self._count), ear.count
        if not new:
            return
        self._began_s = self._began_s or new[0].time_s
        self._curves.extend(drawings.live_columns(new, self._began_s), keep=KEPT_S)
        self._values.text = drawings.live_values(new[-1])
        if ear.conditions != self._told:
            self._told = dict(ear.conditions)
            self._tell_conditions()

    def _tell_conditions(self) -> None:
        self._conditions.clear()
        with self._conditions:
            for name, (level, text) in sorted(self._told.items()):
                told = f"{name.rpartition('/')[2]}: {LEVELS[min(level, 2)]}, {text}"
                ui.label(told).classes("condition" if level == 0 else "condition bad")

    def _hardware(self) -> None:
        """The real bench takes a second step: the word has to be typed."""
        if shutil.which("ros2") is None:
            ui.label("The real bench needs ros2 launch, which is not installed here.").classes("conditions")
            return
        with ui.dialog() as dialog, ui.card():
            ui.label(f"The laser will shine on the real strip. Type {ARMED} to arm it.")
            typed = ui.input("Arm").mark("arm")

            def run() -> None:
                dialog.close()
                typed.set_value("")
                self._run_hardware()

            go = ui.button("Run", color="negative", on_click=telling(run)).mark("run hardware")
            go.bind_enabled_from(typed, "value", lambda word: word == ARMED)
        ui.button("Run on the real bench …", on_click=dialog.open).props("outline no-caps")

    def _run(self) -> None:
        settings = str(self._settings.value or "").split()
        run_simulated(self._bench, str(self._protocol.value or ""), str(self._model.value or ""), settings)

    def _run_hardware(self) -> None:
        bench = self._bench
        name, protocol, out = _recording(bench, str(self._protocol.value or ""))
        bench.record(name, work.run_hardware, protocol=protocol, out=out, domain=bench.ear.open())


def run_simulated(bench: Workbench, protocol: str, model: str = "", settings: Sequence[str] = ()) -> None:
    """Begin a run on the simulated bench: a strip as in a model file of the folder, or the built-in one."""
    name, protocol, out = _recording(bench, protocol)
    strip = _inside(bench.folder, model.strip(), ".yaml", "no model file in this folder") if model.strip() else None
    bench.record(name, work.run, protocol=protocol, out=out, model=strip, settings=settings, domain=bench.ear.open())


def _recording(bench: Workbench, protocol: str) -> tuple[str, str, Path]:
    """Name, protocol and new folder of a recording; a wave file has to lie in the folder of the page."""
    protocol = protocol.strip()
    if protocol.partition(":")[0] not in SHAPES:
        protocol = str(_inside(bench.folder, protocol, ".csv", "neither a protocol nor a CSV file in this folder"))
    kind = Path(protocol).stem.partition(":")[0]
    return f"Run {kind}", protocol, bench.folder / f"{datetime.now(UTC):%Y%m%d-%H%M%S}_{kind}"


def _inside(folder: Path, text: str, suffix: str, else_: str) -> Path:
    """A file of the folder; LceError for any other."""
    file = (folder / text).resolve()
    if not (file.is_relative_to(folder) and file.suffix == suffix and file.is_file()):
        raise LceError(f"{text}: {else_}")
    return file
