# SPDX-License-Identifier: Apache-2.0
"""Which effect is missing: the verdict, the errors in three columns, the ranking, and each candidate in detail."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

from nicegui import ui

from lce_app.workbench import command_lines, drawings, tasks
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.figures import Figures
from lce_app.workbench.kept_blocks import blocks_of
from lce_app.workbench.memory import turn_to
from lce_app.workbench.records import CandidateRecord
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.tabs import discover
from lce_app.workbench.texts import code, heading
from lce_model.effects import library
from lce_report.figures.leading import LeadingCandidate
from lce_report.tables import outcome

VERDICTS: Final = {
    "adequate": "Adequate: nothing is missing",
    "missing": "An effect is missing",
    "unexplained": "Unexplained: something is missing that the library does not hold",
    "cannot_tell": "Cannot tell: these data do not say",
}


def fill(state: WorkbenchState) -> None:
    """The button, the answer, and the candidates."""
    train, test = len(state.runs("train")), len(state.runs("test"))
    if state.session.current is None or not train:
        ui.label("A model and a run to learn from are needed. Fit a model on the tab Add.")
        return
    with ui.row().classes("line"):
        ui.button("Diagnose", color="accent", on_click=notify_errors(lambda: diagnose(state))).props(
            "unelevated no-caps"
        ).mark("diagnose")
        judged = f"judged on {test} held out" if test else "none is held out to judge on (tab Runs)"
        ui.label(f"which effect of the library explains {train} {'run' if train == 1 else 'runs'}; {judged}")
    found = state.diagnosis()
    if found is None:
        ui.label("This model has not been diagnosed yet.")
        return
    with ui.element("section").classes("answer").props('aria-label="the answer"'):
        heading(VERDICTS[found.verdict]).mark("verdict")
        for sentence in found.sentences:
            ui.label(sentence)
    discover.fill(state, found.verdict)
    Figures(lambda: drawings.diagnosis(found)).mark("tables")
    for section in found.sections:
        heading(section.heading)
        Figures(partial(blocks_of, section)).mark(f"section {section.heading}")
    leading = {candidate.effect: candidate for candidate in found.leading}
    tried = [candidate for candidate in found.candidates if candidate.standing != "not tried"]
    for title, members in (
        ("Tried", tried),
        ("Not tried: they promised too little", [c for c in found.candidates if c not in tried]),
    ):
        if members:
            heading(title)
        for candidate in members:
            _candidate(state, candidate, leading.get(candidate.effect))
    Figures(lambda: drawings.evidence(found)).mark("evidence")


def diagnose(state: WorkbenchState) -> None:
    """Begin the diagnosis of the current model."""
    number = state.session.current
    assert number is not None
    state.start(
        "Diagnose",
        tasks.diagnose,
        runs=state.paths("train"),
        test=state.paths("test"),
        model=state.session.model_file(number),
        out=state.session.diagnosis_file(number),
    )


def add(state: WorkbenchState, effect: str) -> None:
    """Begin adding an effect to the current model, and show where its error falls."""
    number = state.session.current
    assert number is not None
    model = state.session.model_file(number)
    state.start_model(
        f"Add {effect}",
        tasks.add,
        f"{effect} added to model {number}",
        number,
        command_lines.add(state, effect, model),
        effect=effect,
        runs=state.paths("train"),
        test=state.paths("test"),
        model=model,
    )
    turn_to("Add")


def _candidate(state: WorkbenchState, candidate: CandidateRecord, leading: LeadingCandidate | None) -> None:
    tried = candidate.standing != "not tried"
    caption = outcome(candidate.standing, candidate.reason) if tried else candidate.meaning
    with (
        ui.expansion(candidate.effect, caption=caption)
        .classes("candidate")
        .mark(f"candidate {candidate.effect}") as open_
    ):
        _described(candidate)
        values = ", ".join(f"{key} = {value:.3g}" for key, value in candidate.settings.items())
        ui.label(f"{'Refitted' if tried else 'Expected'}: {values}.")
        if not candidate.shown:
            ui.label("These data would not show it, at any strength within its bounds.")
        if candidate.aliases:
            ui.label(
                f"In these data it looks like {', '.join(candidate.aliases)}. The tab Design designs the "
                "experiment that would tell."
            )
        place = ui.element("div")
        ui.button(f"Add {candidate.effect}", on_click=notify_errors(partial(add, state, candidate.effect))).props(
            "outline no-caps"
        ).classes("as-wide").mark(f"add {candidate.effect}")
    open_.on_value_change(_once(lambda: _picture(state, candidate, leading, place)))


def _described(candidate: CandidateRecord) -> None:
    """Title, equation and parameters; an effect of the user's own has its meaning here."""
    effect = library().get(candidate.effect)
    if effect is None:
        ui.label(candidate.meaning)
        return
    ui.label(f"{effect.title}: {effect.meaning}")
    code(effect.equation)
    with ui.element("ul"):
        for p in effect.parameters:
            with ui.element("li"):
                unit = "" if p.unit == "1" else f" {p.unit}"
                ui.label(f"{p.name}: {p.description}, {p.lower:g} … {p.upper:g}{unit} ({p.source})")


def _picture(
    state: WorkbenchState, candidate: CandidateRecord, leading: LeadingCandidate | None, place: ui.element
) -> None:
    """Draw what the refit with the effect changed; of one that was not tried, what it would change before a refit."""
    model, run = state.model(), next(iter(state.runs("train").values()), None)
    with place:
        if leading is not None:
            Figures(lambda: drawings.leading(leading))
        elif model is not None and run is not None:
            Figures(lambda: drawings.signature(model, run, candidate.effect, candidate.settings))


def _once(act: Callable[[], None]) -> Callable[[], None]:
    """The act, the first time it is called."""
    acts = [act]
    return lambda: acts.pop()() if acts else None
