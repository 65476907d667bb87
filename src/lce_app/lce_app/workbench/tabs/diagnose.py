# SPDX-License-Identifier: Apache-2.0
"""Which effect is missing: the verdict, the errors in three columns, the ranking, and each candidate in detail."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

from nicegui import ui

from lce_app.use_cases.fit import ModelChoice
from lce_app.workbench import adding, drawings, tasks
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.figures import Figures
from lce_app.workbench.kept_blocks import blocks_of
from lce_app.workbench.memory import turn_to
from lce_app.workbench.records import CandidateRecord, DiagnosisRecord, OtherBaseRecord
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.tabs import discover
from lce_app.workbench.texts import code, heading
from lce_data.units import after_number
from lce_model.effects import library
from lce_report.figures.leading import LeadingCandidate
from lce_report.tables import outcome

VERDICTS: Final = {
    "adequate": "Adequate: no effect is missing",
    "missing": "An effect is missing",
    "unexplained": "Unexplained: no effect of the library explains enough of what is left",
    "cannot_tell": "Cannot tell: these data do not say",
}
OTHER_BASE: Final = "Another base model does better"


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
    _other_runs(state, found)
    with ui.element("section").classes("answer").props('aria-label="the answer"'):
        heading(OTHER_BASE if found.other_base else VERDICTS[found.verdict]).mark("verdict")
        for sentence in found.sentences:
            ui.label(sentence)
        if found.other_base is not None:
            _begin_button(state, found.other_base)
        for effect in found.added[:1]:
            _add_button(state, effect, "unelevated")
    discover.fill(state, found.verdict)
    Figures(lambda: drawings.diagnosis(found)).mark("tables")
    for section in found.sections:
        heading(section.heading)
        Figures(partial(blocks_of, section)).mark(f"section {section.heading}")
    leading = {candidate.effect: candidate for candidate in found.leading}
    tried = [candidate for candidate in found.candidates if candidate.standing != "not tried"]
    for title, members in (
        ("Tried", tried),
        (
            "Not tried: they promised too little, or less than those above",
            [c for c in found.candidates if c not in tried],
        ),
    ):
        if members:
            heading(title)
        for candidate in members:
            _candidate(state, candidate, leading.get(candidate.effect), found.added)
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


def _other_runs(state: WorkbenchState, found: DiagnosisRecord) -> None:
    """A line above an answer that was found from other runs than those in use now."""
    if found.runs is None or found.held_out is None or found.files in (None, state.read_by_jobs()):
        return
    judged = f"judged on {', '.join(found.held_out)}" if found.held_out else "none was held out"
    ui.label(
        "This answer is of other runs than those in use now, or of runs prepared in another way: "
        f"found from {', '.join(found.runs)}; {judged}. "
        "Diagnose again to ask those in use."
    ).mark("other runs")


def _begin_button(state: WorkbenchState, other: OtherBaseRecord) -> None:
    """Identifies the base model that does better; effect files of the user's own are left to the command."""
    model = state.model()
    if model is None or set(other.effects) - library().keys():
        return
    choice = ModelChoice(model.thermal, other.deformation, other.effects, varies=other.varies)

    def begin() -> None:
        adding.fit(state, choice)
        turn_to("Add")

    words = " with ".join([other.deformation, ", ".join(other.effects)] if other.effects else [other.deformation])
    ui.button(f"Fit {words}", on_click=notify_errors(begin)).props("unelevated no-caps").classes("as-wide").mark(
        "begin"
    )


def _add_button(state: WorkbenchState, effect: str, style: str) -> None:
    """Adds an effect; that of the answer has its button there, where it is seen."""
    add = notify_errors(partial(adding.add, state, effect))
    ui.button(f"Add {effect}", on_click=add).props(f"{style} no-caps").classes("as-wide").mark(f"add {effect}")


def _candidate(
    state: WorkbenchState, candidate: CandidateRecord, leading: LeadingCandidate | None, added: Sequence[str]
) -> None:
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
        if not candidate.shown and candidate.standing not in ("missing", "trace"):
            ui.label("These data would not show it, at any strength within its bounds.")
        if candidate.aliases:
            ui.label(
                f"In these data it looks like {', '.join(candidate.aliases)}. The tab Design designs the "
                "experiment that would tell."
            )
        place = ui.element("div")
        if candidate.effect not in added[:1]:
            _add_button(state, candidate.effect, "outline")
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
                ends = f"{p.lower:g} … {p.upper:g}{after_number(p.unit)}"
                ui.label(f"{p.name}: {p.description}, {ends} ({p.source})")


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
