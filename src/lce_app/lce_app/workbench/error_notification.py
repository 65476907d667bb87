# SPDX-License-Identifier: Apache-2.0
"""A request that cannot be met becomes a one-line notification on the page."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from lce_data.errors import LceError


def notify_errors(act: Callable[[], object]) -> Callable[[], None]:
    """The act, whose LceError is shown as a notification."""

    def tried() -> None:
        try:
            act()
        except LceError as error:
            ui.notify(" ".join(str(error).split()), type="negative")

    return tried


def notify_errors_of(act: Callable[[], Awaitable[object]]) -> Callable[[], Awaitable[None]]:
    """The same of an act that takes a while."""

    async def tried() -> None:
        try:
            await act()
        except LceError as error:
            ui.notify(" ".join(str(error).split()), type="negative")

    return tried
