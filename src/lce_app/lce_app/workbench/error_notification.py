# SPDX-License-Identifier: Apache-2.0
"""What a user asked for and cannot have is told on the page, in one line."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from lce_data.errors import LceError


def telling(act: Callable[[], object]) -> Callable[[], None]:
    """The act, whose LceError becomes a notice."""

    def tried() -> None:
        try:
            act()
        except LceError as error:
            ui.notify(" ".join(str(error).split()), type="negative")

    return tried
