# SPDX-License-Identifier: Apache-2.0
"""What no library holds, on the tab Diagnose: the button, the answer, and each function found with its slider."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final

from nicegui import ui

from lce_app.workbench import command_lines, own_effects, tasks
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.figures import Figures
from lce_app.workbench.kept_blocks import blocks_of
from lce_app.workbench.records import DiscoveryRecord, FoundRecord, read_discovery
from lce_app.workbench.sliders import StrengthSlider
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import code, heading, named
from lce_model import Model
from lce_model.trust import sha256, trust
from lce_report.pages.discovery import WHAT_WAS_FOUND

ASKED_AFTER: Final = ("unexplained", "cannot_tell")
"""Verdicts of a diagnosis that leave something to be discovered."""
VERDICTS: Final = {
    "found": "Found: a function that no effect of the library is",
    "disturbance": "A disturbance: it does not repeat, so it has no formula",
    "nothing": "Nothing found",
}


def fill(state: WorkbenchState, verdict: str) -> None:
    """The button, if the diagnosis leaves something to be discovered; and what was discovered, if anything was."""
    if verdict in ASKED_AFTER:
        with ui.row().classes("line"):
            ui.button("Discover", color="accent", on_click=notify_errors(lambda: discover(state))).props(
                "unelevated no-caps"
            ).mark("discover")
            ui.label("which unknown function is missing, where it acts, and its formula; takes a minute or two")
    found = state.discovery()
    if found is None:
        return
    with ui.element("section").classes("answer").props('aria-label="what was discovered"'):
        heading(VERDICTS[found.verdict]).mark("discovered")
        for sentence in found.sentences:
            ui.label(sentence)
    for section in found.sections:
        heading(section.heading)
        Figures(partial(blocks_of, section)).mark(f"section {section.heading}")
        if section.heading == WHAT_WAS_FOUND:
            for one in found.found:
                _function(state, found, one)
    heading("What the library holds")


def discover(state: WorkbenchState) -> None:
    """Begin the search for what the current model lacks; the effect files that it writes are trusted for good."""
    number = state.session.current
    assert number is not None
    out = state.session.discovery_file(number)
    state.start(
        "Discover",
        tasks.discover,
        lambda: _trust_written(state, out),
        runs=state.paths("train"),
        test=state.paths("test"),
        model=state.session.model_file(number),
        effect_file=state.session.next_found_file(number),
        out=out,
    )


def _trust_written(state: WorkbenchState, out: Path) -> None:
    """Trust what the job has written, unless it has changed since."""
    for found in read_discovery(out).found:
        file = _file(state, found)
        if file.is_file() and sha256(file) == found.sha256:
            trust(file)


def _file(state: WorkbenchState, found: FoundRecord) -> Path:
    """The effect file, in the folder of the page's own files and nowhere else."""
    return state.session.place / Path(found.file).name


def _function(state: WorkbenchState, found: DiscoveryRecord, one: FoundRecord) -> None:
    """What was found as a file: the text, the slider on its strength, and the button that adds it."""
    file = _file(state, one)
    with named(ui.element("section").classes("found"), one.effect).mark(f"found {one.effect}"):
        heading(one.effect)
        if not file.is_file():
            ui.label(f"{file.name} is no longer there. Discover again.").classes("bad")
            return
        if not own_effects.show(state, file):
            return
        if one.rival:
            ui.label("Another formula describes the curve as well. This finds the run that tells the two apart:")
            number = state.session.current
            assert number is not None
            line = command_lines.tell_apart(state, state.session.model_file(number), file, file.with_name(one.rival))
            code(line)
        ui.button(f"Add {one.effect}", on_click=notify_errors(partial(own_effects.add, state, file))).props(
            "outline no-caps"
        ).classes("as-wide").mark(f"add {one.effect}")
        model = state.model()
        if model is not None and state.used():
            effect = own_effects.effect_of(file)
            StrengthSlider(state, model, with_values(model, found).add(str(file)), effect)


def with_values(model: Model, found: DiscoveryRecord) -> Model:
    """The model with the values that its parameters had when it was refitted with what was found."""
    return model.set({key: value for key, value in found.values.items() if key in model and value != model[key]})
