# SPDX-License-Identifier: Apache-2.0
"""The fields for a recording that the page makes: specimen, day, conditions and notes."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from nicegui import ui

from lce_data.given_conditions import parse_conditions

MM_PER_M = 1000.0


class RecordingForm:
    """The fields, filled with what was ``remembered`` of the last recording; the day is today, notes begin empty."""

    def __init__(self, remembered: Mapping[str, Any]) -> None:
        length_m = remembered.get("strip_length_m")
        length_mm = f"{length_m * MM_PER_M:g}" if isinstance(length_m, int | float) else ""
        with ui.row().classes("line recording"):
            self._specimen = ui.input("Specimen", value=str(remembered.get("specimen", ""))).mark("specimen")
            self._day = ui.input("Day", value=f"{datetime.now(UTC).astimezone():%Y-%m-%d}").mark("day")
            self._length = ui.input("Strip length [mm]", value=length_mm).mark("strip length")
            self._ambient = ui.input("Ambient [°C]", value=_text(remembered.get("ambient_c"))).mark("ambient")
            self._load = ui.input("Load [N]", value=_text(remembered.get("load_n"))).mark("load")
        self._notes = ui.textarea("Notes").props("autogrow rows=1 maxlength=4000").classes("notes").mark("notes")

    def conditions(self) -> dict[str, Any]:
        """The conditions, in the units of experiment.yaml. Raises LceError that names one that cannot be."""
        words = {
            "specimen": self._specimen.value,
            "day": self._day.value,
            "ambient_c": self._ambient.value,
            "load_n": self._load.value,
            "strip_length_m": self._length.value,
            "notes": self._notes.value,
        }
        found = parse_conditions({key: str(value or "").strip() for key, value in words.items()})
        if isinstance(length_mm := found.get("strip_length_m"), float):
            found["strip_length_m"] = length_mm / MM_PER_M
        return found


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float) else ""
