# SPDX-License-Identifier: Apache-2.0
"""Run an experiment and see it live: values and curves from the topics, what the nodes say, and the stop button."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from nicegui import ui

from lce_bringup.workbench import drawings, work
from lce_bringup.workbench.bench import Workbench
from lce_bringup.workbench.figures import Figures
from lce_bringup.workbench.live import KEPT_S
from lce_bringup.workbench.telling import telling
from lce_model.errors import LceError
from lce_model.waveforms import SHAPES

LEVELS: Final = ("ok", "warning", "error")
ARMED: Final = "hardware"


def bench(workbench: Workbench) -> Callable[[], None]:
    """The tab, and what brings it up to date."""
    return Bench(workbench).follow


class Bench:
    """The tab; ``follow`` brings the live part up to date."""

    def __init__(self, bench: Workbench) -> None:
        self._bench, self._count, self._began_s = bench, bench.ear.count, 0.0
        with ui.row().classes("line"):
            self._protocol = ui.input("Protocol", value="pulse:amp=0.4,th=20").classes("protocol").mark("protocol")
            self._settings = ui.input("Strip: EFFECT.PARAM=V …").classes("protocol").mark("settings")
            ui.button("Run on the simulated bench", color="accent", on_click=telling(self._run)).props(
                "unelevated no-caps"
            ).mark("start")
            self._hardware()
            ui.button("Stop: laser to zero", color="negative", on_click=self._stop).props("unelevated no-caps").mark(
                "stop"
            )
        ui.label(
            f"Protocols: {', '.join(SHAPES)}, with options as for lce run, or a CSV file of this folder. Esc stops."
        )
        self._values = ui.label().classes("values").props("role=status").mark("values")
        self._conditions = ui.label().classes("conditions").mark("conditions")
        self._curves = Figures(drawings.live)
        ui.keyboard(on_key=lambda event: self._stop() if event.key.escape and event.action.keydown else None)

    def follow(self) -> None:
        """Show what was heard since the last time."""
        ear = self._bench.ear
        new, self._count = ear.since(self._count), ear.count
        if not new:
            return
        self._began_s = self._began_s or new[0].time_s
        self._curves.extend(drawings.live_columns(new, self._began_s), keep=KEPT_S)
        self._values.text = drawings.live_values(new[-1])
        told = [
            f"{name.rpartition('/')[2]}: {LEVELS[min(level, 2)]}, {text}"
            for name, (level, text) in sorted(ear.conditions.items())
        ]
        self._conditions.text = " · ".join(told)

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
        name, protocol, out = self._recording()
        settings, domain = str(self._settings.value or "").split(), self._bench.ear.open()
        self._bench.record(name, work.run, protocol=protocol, out=out, settings=settings, domain=domain)

    def _run_hardware(self) -> None:
        name, protocol, out = self._recording()
        self._bench.record(name, work.run_hardware, protocol=protocol, out=out, domain=self._bench.ear.open())

    def _recording(self) -> tuple[str, str, Path]:
        """Name, protocol and new folder of a recording; a wave file has to lie in the folder of the page."""
        protocol, folder = str(self._protocol.value or "").strip(), self._bench.folder
        if protocol.partition(":")[0] not in SHAPES:
            file = (folder / protocol).resolve()
            if not (file.is_relative_to(folder) and file.suffix == ".csv" and file.is_file()):
                raise LceError(f"{protocol}: neither a protocol nor a CSV file in this folder")
            protocol = str(file)
        kind = Path(protocol).stem.partition(":")[0]
        name = f"{datetime.now(UTC):%Y%m%d-%H%M%S}_{kind}"
        return f"Run {kind}", protocol, folder / name

    def _stop(self) -> None:
        if self._bench.job is not None and self._bench.job.gentle:
            self._bench.cancel()
