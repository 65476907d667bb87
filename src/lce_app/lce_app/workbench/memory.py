# SPDX-License-Identifier: Apache-2.0
"""What a page remembers while its tabs are filled anew: choices, and the tabs themselves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from nicegui import app, ui
from nicegui.events import ValueChangeEventArguments


def remembered(key: str, options: Sequence[str]) -> str:
    """What was chosen last on this page, if it can still be, else the first option."""
    chosen = str(app.storage.client.get(key))
    return chosen if chosen in options else options[0]


def remember(key: str, event: ValueChangeEventArguments[str]) -> None:
    """Remember a choice."""
    app.storage.client[key] = event.value


def keep_tabs(tabs: ui.tabs) -> None:
    """Remember the tabs of this page."""
    app.storage.client["tabs"] = tabs


def hand_over(table: Path) -> None:
    """Leave a table for the tab Import of this page."""
    app.storage.client["table"] = table


def handed_over() -> Path | None:
    """Take the table that was left, once."""
    table: Path | None = app.storage.client.pop("table", None)
    return table


def turn_to(tab: str) -> None:
    """Show another tab of this page."""
    app.storage.client["tabs"].set_value(tab)
