# SPDX-License-Identifier: Apache-2.0
"""Conditions of a run as a user states them: specimen, day, notes and numbers, checked before anything is recorded.

They are data: whatever a text holds, it is kept as text.
"""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Mapping
from typing import Any, Final

from lce_data.errors import LceError
from lce_data.experiment_file import Conditions, conditions_of
from lce_data.files import printable
from lce_data.units import KELVIN

LONGEST: Final = {"notes": 4000}
"""Characters of a text at most, by key; of any other text `LONGEST_TEXT`."""
LONGEST_TEXT: Final = 200
MOST: Final = 50
"""Conditions of a run at most."""
TEXTS: Final = ("specimen", "day", "notes")
"""Conditions that are text, even where they look like a number."""


def parse_conditions(words: Mapping[str, str]) -> dict[str, Any]:
    """Conditions by key from what was typed: a number where it reads as one, else text; empty ones are left out."""
    return check_conditions({key: value if key in TEXTS else _number_or_text(value) for key, value in words.items()})


def check_conditions(given: Mapping[str, Any]) -> dict[str, Any]:
    """The conditions as they are recorded: texts without control characters, in composed form, and finite numbers.

    Raises LceError that names the key and the value.
    """
    if len(given) > MOST:
        raise LceError(f"{len(given)} conditions; a run has {MOST} at most")
    checked: dict[str, Any] = {}
    for key, value in given.items():
        if not key.isidentifier():
            raise LceError(f"condition {key!r}: a key is a word of letters, digits and _, such as humidity_pct")
        if isinstance(value, str):
            value = _clean(key, value)
        elif isinstance(value, float) and not math.isfinite(value):
            raise LceError(f"condition {key} is {value}; it must be a finite number")
        if value not in ("", None):
            checked[key] = value
    _check_numbers(conditions_of(checked))
    return checked


def _check_numbers(conditions: Conditions) -> None:
    if conditions.ambient_c is not None and conditions.ambient_c < -KELVIN:
        raise LceError(f"condition ambient_c is {conditions.ambient_c:g} °C, below absolute zero")


def _clean(key: str, text: str) -> str:
    """A text in composed form (NFC). Of the control characters the end of a line and the tab are kept."""
    text = printable(unicodedata.normalize("NFC", text.replace("\r\n", "\n").replace("\r", "\n")))
    text = "".join(c for c in text if c in "\n\t" or unicodedata.category(c) != "Cc").strip()
    longest = LONGEST.get(key, LONGEST_TEXT)
    if len(text) > longest:
        raise LceError(f"condition {key} has {len(text)} characters; {longest} are the most")
    return text


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
