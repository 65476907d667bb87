# SPDX-License-Identifier: Apache-2.0
"""Run an experiment and see it live: values and curves from the topics, what the nodes say, and the stop button."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final

from nicegui import run, ui

from lce_app.use_cases.record import arm_laser
from lce_app.workbench import drawings, tasks
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.figures import Figures
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.topic_monitor import KEPT_S
from lce_data.errors import LceError
from lce_data.settings import parse_settings
from lce_data.waveforms import SHAPES
from lce_experiment.plan import new_folder

LEVELS: Final = ("ok", "warning", "error")
WORD: Final = "hardware"


def fill(state: WorkbenchState) -> Callable[[], None]:
    """The tab, and what brings it up to date."""
    return BenchTab(state).follow


class BenchTab:
    """The tab; ``follow`` brings the live part up to date."""

    def __init__(self, state: WorkbenchState) -> None:
        self._state, self._count, self._began_s = state, state.monitor.count, 0.0
        self._shown: dict[str, tuple[int, str]] = {}
        with ui.row().classes("line"):
            self._protocol = ui.input("Protocol", value="pulse:amp=0.4,th=20").classes("protocol").mark("protocol")
            self._model = ui.input("Simulated strip", placeholder="built in, or a model file").classes("protocol")
            self._settings = ui.input("Its parameters", placeholder="creep.share=0.1 …").classes("protocol")
        with ui.row().classes("line"):
            ui.button("Run on the simulated bench", color="accent", on_click=notify_errors(self._run)).props(
                "unelevated no-caps"
            ).mark("start")
            self._hardware()
            ui.button("Stop: laser to zero", color="negative", on_click=state.stop).props("unelevated no-caps").mark(
                "stop"
            )
        ui.label(
            f"Protocols: {', '.join(SHAPES)}, with options as for lce run, or a CSV file of this folder. Esc stops."
        )
        self._values = ui.label("nothing received yet").classes("values").props("role=status").mark("values")
        self._conditions = ui.element("div").classes("conditions").mark("conditions")
        self._curves = Figures(drawings.live)

    def follow(self) -> None:
        """Show the snapshots since the last time."""
        monitor = self._state.monitor
        new, self._count = monitor.since(self._count), monitor.count
        if not new:
            return
        self._began_s = self._began_s or new[0].time_s
        self._curves.extend(drawings.live_columns(new, self._began_s), keep=KEPT_S)
        self._values.text = drawings.live_values(new[-1])
        if monitor.conditions != self._shown:
            self._shown = dict(monitor.conditions)
            self._show_conditions()

    def _show_conditions(self) -> None:
        self._conditions.clear()
        with self._conditions:
            for name, (level, text) in sorted(self._shown.items()):
                line = f"{name.rpartition('/')[2]}: {LEVELS[min(level, 2)]}, {text}"
                ui.label(line).classes("condition" if level == 0 else "condition bad")

    def _hardware(self) -> None:
        """Running on the real bench takes a second step: a word has to be typed."""
        if shutil.which("ros2") is None:
            ui.label("The real bench needs ros2 launch, which is not installed here.").classes("conditions")
            return
        with ui.dialog() as dialog, ui.card():
            ui.label(f"The laser will shine on the real strip once it is armed. Type {WORD} to run.")
            typed = ui.input("Word").mark("word")

            def begin() -> None:
                dialog.close()
                typed.set_value("")
                self._run_hardware()

            go = ui.button("Run", color="negative", on_click=notify_errors(begin)).mark("run hardware")
            go.bind_enabled_from(typed, "value", lambda word: word == WORD)
        ui.button("Run on the real bench …", on_click=dialog.open).props("outline no-caps")
        ui.button("Arm its laser", color="negative", on_click=self._arm).props("outline no-caps").mark("arm")

    async def _arm(self) -> None:
        try:
            await run.io_bound(arm_laser, self._state.monitor.open())
        except LceError as error:
            ui.notify(" ".join(str(error).split()), type="negative")
        else:
            ui.notify("armed", type="warning")

    def _run(self) -> None:
        settings = parse_settings(str(self._settings.value or "").split())
        run_simulated(self._state, str(self._protocol.value or ""), str(self._model.value or ""), settings)

    def _run_hardware(self) -> None:
        state = self._state
        name, protocol, out = _recording(state, str(self._protocol.value or ""))
        state.record(name, tasks.run_hardware, protocol=protocol, out=out, domain=state.monitor.open())


def run_simulated(
    state: WorkbenchState, protocol: str, model: str = "", settings: Mapping[str, float] = MappingProxyType({})
) -> None:
    """Begin a run on the simulated bench: a strip as in a model file of the folder, or the built-in one."""
    name, protocol, out = _recording(state, protocol)
    strip = _inside(state.folder, model.strip(), ".yaml", "no model file in this folder") if model.strip() else None
    state.record(
        name, tasks.run, protocol=protocol, out=out, model=strip, settings=dict(settings), domain=state.monitor.open()
    )


def _recording(state: WorkbenchState, protocol: str) -> tuple[str, str, Path]:
    """Name, protocol and new folder of a recording; a wave file has to lie in the folder of the page."""
    protocol = protocol.strip()
    if protocol.partition(":")[0] not in SHAPES:
        protocol = str(_inside(state.folder, protocol, ".csv", "neither a protocol nor a CSV file in this folder"))
    kind = Path(protocol).stem.partition(":")[0]
    return f"Run {kind}", protocol, new_folder(state.folder, kind)


def _inside(folder: Path, text: str, suffix: str, else_: str) -> Path:
    """A file of the folder; LceError with the text ``else_`` for any other."""
    file = (folder / text).resolve()
    if not (file.is_relative_to(folder) and file.suffix == suffix and file.is_file()):
        raise LceError(f"{text}: {else_}")
    return file
