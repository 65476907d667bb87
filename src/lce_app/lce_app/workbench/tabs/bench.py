# SPDX-License-Identifier: Apache-2.0
"""Run an experiment and see it live: values and curves from the topics, what the nodes say, and the stop button."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from nicegui import run, ui

from lce_app.use_cases.record import arm_laser
from lce_app.workbench import drawings, tasks
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.live_panel import LivePanel
from lce_app.workbench.recording_form import RecordingForm
from lce_app.workbench.state import WorkbenchState
from lce_data.errors import LceError
from lce_data.settings import parse_settings
from lce_data.topics import DIAGNOSTICS, RECORDED
from lce_data.waveforms import SHAPES
from lce_experiment.plan import new_folder
from lce_experiment.registry import NAMESPACE

LEVELS: Final = ("ok", "warning", "error")
WORD: Final = "hardware"


def fill(state: WorkbenchState) -> Callable[[], None]:
    """The tab, and what brings it up to date."""
    return BenchTab(state).follow


class BenchTab:
    """The tab; ``follow`` brings the live part up to date."""

    def __init__(self, state: WorkbenchState) -> None:
        self._state, self._count = state, state.monitor.count
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
            stop = ui.button("Stop: laser to zero", color="negative", on_click=notify_errors(self._stop))
            stop.props("unelevated no-caps").mark("stop")
            self._listen = ui.button("Record what runs now", on_click=notify_errors(self._record_or_end))
            self._listen.props("outline no-caps").mark("record")
        ui.label(
            f"Protocols: {', '.join(SHAPES)}, with options as for lce run, or a CSV file of this folder. Esc stops."
        )
        self._form = RecordingForm(state.live.conditions)
        self._values = ui.label("nothing received yet").classes("values").props("role=status").mark("values")
        self._conditions = ui.element("div").classes("conditions").mark("conditions")
        self._live = LivePanel(state)

    def follow(self) -> None:
        """Show the snapshots since the last time."""
        monitor = self._state.monitor
        self._live.follow()
        self._listen.text = "Stop recording" if self._listening else "Record what runs now"
        if monitor.count == self._count:
            return
        self._count = monitor.count
        self._values.text = drawings.live_values(monitor.snapshots[-1])
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
        protocol, model = str(self._protocol.value or ""), str(self._model.value or "")
        conditions = self._form.conditions()
        run_simulated(self._state, protocol, model, settings, conditions)
        self._state.live.remember(conditions)

    def _run_hardware(self) -> None:
        state, conditions = self._state, self._form.conditions()
        name, protocol, out = _recording(state, str(self._protocol.value or ""))
        domain = state.monitor.open()
        state.record(name, tasks.run_hardware, protocol=protocol, out=out, domain=domain, conditions=conditions)
        state.live.remember(conditions)

    @property
    def _listening(self) -> bool:
        job = self._state.job
        return job is not None and self._state.working and job.only_listens

    def _stop(self) -> None:
        if self._listening:
            raise LceError("this page only records; stop the laser where the run was started")
        self._state.stop()

    def _record_or_end(self) -> None:
        """Record a bench that others run, or end that recording."""
        state = self._state
        if self._listening:
            state.cancel()
            return
        monitor, conditions = state.monitor, self._form.conditions()
        if not (monitor.conditions or (monitor.snapshots and monitor.snapshots[-1].values)):
            raise LceError(
                "no topic of a bench is heard; start the workbench with the ROS_DOMAIN_ID in which the bench runs"
            )
        if monitor.recording:
            raise LceError("a recorder is at work already")
        out, domain = new_folder(state.folder, "recording"), monitor.open()
        state.record(
            "Record",
            tasks.record_topics,
            out=out,
            only_listens=True,
            domain=domain,
            conditions=conditions,
            topics=shown_besides(state),
        )
        state.live.remember(conditions)


def shown_besides(state: WorkbenchState) -> list[str]:
    """The topics of the live plots that are not always recorded, as the recorder wants them named."""
    always = {DIAGNOSTICS, *(f"{NAMESPACE}/{topic}" for topic in RECORDED)}
    shown = {series.topic for series in state.live.layout.series} - always
    return [f"{topic.name} {topic.type}" for topic in state.monitor.topics if topic.name in shown]


def run_simulated(
    state: WorkbenchState,
    protocol: str,
    model: str = "",
    settings: Mapping[str, float] = MappingProxyType({}),
    conditions: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Begin a run on the simulated bench: a strip as in a model file of the folder, or the built-in one."""
    name, protocol, out = _recording(state, protocol)
    strip = _inside(state.folder, model.strip(), ".yaml", "no model file in this folder") if model.strip() else None
    state.record(
        name,
        tasks.run,
        protocol=protocol,
        out=out,
        model=strip,
        settings=dict(settings),
        domain=state.monitor.open(),
        conditions=dict(conditions),
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
