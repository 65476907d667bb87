# SPDX-License-Identifier: Apache-2.0
"""Models: fit one, add an effect, the history with its falling error, before and after, and sliders."""

from __future__ import annotations

from functools import partial

from nicegui import ui

from lce_app.use_cases.fit import ModelChoice
from lce_app.workbench import adding, drawings, own_effects
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.figures import Figures
from lce_app.workbench.sliders import Sliders
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.suggestions import effect_to_add
from lce_app.workbench.texts import named
from lce_model.effects import library
from lce_model.library import DEFORMATION, THERMAL


def fill(state: WorkbenchState) -> None:
    """The models of the session, and what makes more of them."""
    with ui.row().classes("line"):
        thermal = ui.select(list(THERMAL), value="lumped", label="Thermal stage")
        deformation = ui.select(list(DEFORMATION), value="equilibrium", label="Deformation stage")
        ui.button(
            "Fit a model",
            color="accent",
            on_click=notify_errors(lambda: adding.fit(state, ModelChoice(str(thermal.value), str(deformation.value)))),
        ).props("unelevated no-caps").mark("fit")
    model = state.model()
    if model is None:
        ui.label("No model yet: fit one, or begin with lce workbench --model M.yaml.")
        return
    with ui.row().classes("line"):
        missing = [e.name for e in library().values() if e.name not in model.effect_names]
        effect = ui.select(missing, value=effect_to_add(state, missing), label="Effect").mark("effect")
        ui.button("Add and refit", on_click=notify_errors(lambda: adding.add(state, str(effect.value)))).props(
            "outline no-caps"
        ).mark("add")
    for file in own_effects.files(state):
        with named(ui.element("section").classes("found"), file.stem).mark(f"own {file.name}"):
            if own_effects.show(state, file):
                added = ui.button("Add and refit", on_click=notify_errors(partial(own_effects.add, state, file)))
                added.props("outline no-caps").classes("as-wide").mark(f"add {file.name}")
    _history(state)
    addition = state.addition()
    if addition is not None:
        Figures(lambda: drawings.addition(addition)).mark("addition")
    if state.used():
        Figures(lambda: drawings.history(state)).mark("falling error")
        Figures(lambda: drawings.before_and_after(state)).mark("before and after")
        Sliders(state, model)


def _history(state: WorkbenchState) -> None:
    """Every model; a click makes it the current one."""
    with ui.element("table").classes("models"):
        with ui.element("thead"), ui.element("tr"):
            for head in ("model", "how", "effects", "came from", "use"):
                with ui.element("th").props("scope=col"):
                    ui.label(head)
        with ui.element("tbody"):
            for kept in state.session.models:
                model = state.model(kept.number)
                effects = ", ".join(model.effect_names) if model is not None else ""
                with ui.element("tr").mark(f"model {kept.number}"):
                    for text in (f"{kept.number}", kept.how, effects, "" if kept.parent is None else f"{kept.parent}"):
                        with ui.element("td"):
                            ui.label(text)
                    with ui.element("td"):
                        if kept.number == state.session.current:
                            ui.label("current")
                        else:
                            ui.button("Use", on_click=notify_errors(partial(state.choose, kept.number))).props(
                                f'flat dense no-caps aria-label="use model {kept.number}"'
                            )
