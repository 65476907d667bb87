# SPDX-License-Identifier: Apache-2.0
"""Choices that a page remembers while its tabs are filled anew."""

from __future__ import annotations

from collections.abc import Sequence

from nicegui import app
from nicegui.events import ValueChangeEventArguments


def remembered(key: str, options: Sequence[str]) -> str:
    """What was chosen last on this page, if it can still be, else the first option."""
    chosen = str(app.storage.client.get(key))
    return chosen if chosen in options else options[0]


def remember(key: str, event: ValueChangeEventArguments[str]) -> None:
    """Remember a choice."""
    app.storage.client[key] = event.value
