# SPDX-License-Identifier: Apache-2.0
"""Effect files in the page's own folder: shown to be read, trusted by the user, then added to the current model.

An effect is a program: none runs before it is trusted, nor when its content is another than it was then.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from nicegui import ui

from lce_app.workbench import adding
from lce_app.workbench.error_notification import notify_errors
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import listing
from lce_data.files import read_at_most
from lce_model import trust
from lce_model.effects import Effect, find_trusted
from lce_model.trust import MOST_BYTES, UntrustedEffect


def files(state: WorkbenchState) -> list[Path]:
    """Effect files that the user brought, in the order of their names."""
    place = state.session.own_effects
    return sorted(place.glob("*.py")) if place.is_dir() else []


def effect_of(file: Path) -> Effect:
    """The effect of a file. Raises UntrustedEffect, and does not run it, unless it is trusted as it is now."""
    if not trusted(file):
        raise UntrustedEffect(f"{file.name}: not run, because you have not trusted it as it is now")
    return find_trusted(file)


def trusted(file: Path) -> bool:
    """Has the user trusted the file as it is now?"""
    return trust.is_trusted(trust.sha256(file))


def show(state: WorkbenchState, file: Path) -> bool:
    """The text of the file behind a click, and the button that trusts it if it is not; whether it is trusted."""
    with ui.expansion(file.name, caption="the effect file: what lce add and lce diagnose --effect take"):
        listing(read_at_most(file, MOST_BYTES).decode(errors="replace")).mark("effect file")
    if trusted(file):
        return True
    ui.label(
        f"You have not trusted {file.name}, and no page of yours has written it as it is now. An effect is a program: "
        "read it before you let it run."
    )
    button = ui.button("Trust this file", on_click=notify_errors(partial(_trust, state, file)))
    button.props("outline no-caps").mark("trust")
    return False


def add(state: WorkbenchState, file: Path) -> None:
    """Begin adding the effect of a file to the current model, as `lce add` does."""
    adding.add(state, effect_of(file).name, file)


def _trust(state: WorkbenchState, file: Path) -> None:
    trust.trust(file)
    state.version += 1
