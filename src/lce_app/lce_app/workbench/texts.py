# SPDX-License-Identifier: Apache-2.0
"""Elements whose text or whose name comes from a file: whatever it holds, it is shown as text.

The page writes no HTML of its own, and hands no such name to ``props("…")``, which would read it as more properties.
"""

from __future__ import annotations

from typing import TypeVar

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

Element = TypeVar("Element", bound=ui.element)


def heading(text: str, level: int = 2) -> TextElement:
    """A heading."""
    return TextElement(tag=f"h{level}", text=text)


def code(text: str) -> TextElement:
    """A line of code."""
    return TextElement(tag="code", text=text)


def listing(text: str) -> TextElement:
    """The text of a program, in its lines."""
    return TextElement(tag="pre", text=text)


def named(element: Element, name: str) -> Element:
    """The same element with a name for screen readers."""
    element.props["aria-label"] = name
    return element
