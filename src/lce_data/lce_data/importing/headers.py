# SPDX-License-Identifier: Apache-2.0
"""What a column is, by its header: words for the quantity, and the unit behind them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from lce_data.channels import CHANNELS, NAMED_INPUT, Unit, channel_named
from lce_data.importing.units import find_unit

TIME: Final = "time"
"""The quantity that is no channel."""

SI_UNITS: Final = {TIME: "s", **{channel.name: channel.unit for channel in CHANNELS}}
"""SI unit of everything that a column may be, but for inputs that a user names."""

WORDS: Final = {  # in the order in which they are tried: a room temperature is ambient
    "ambient": ("ambient", "amb", "tamb", "room", "troom", "environment", "surroundings", "outside", "outdoor"),
    "temperature": ("temperature", "temperatures", "temp", "temperatur", "thermocouple", "tc", "tstrip"),
    "load": ("load", "force", "weight", "stress", "tension"),
    "displacement": (
        "displacement", "disp", "contraction", "stroke", "position", "pos", "deflection", "elongation", "extension",
        "travel", "distance", "weg", "strain",
    ),
    "power": ("power", "laser", "heater", "heating", "heat", "drive", "pwm", "duty", "leistung"),
    TIME: ("time", "timestamp", "datetime", "elapsed", "zeit", "clock", "date", "stamp"),
}  # fmt: skip
"""Words that say what a column is."""

LETTERS: Final = (
    ("temperature", r"T\d*|[tT]\d+|theta"),
    (TIME, r"t"),
    ("power", r"[PpQq]\d*|[uU]\d*"),
    ("displacement", r"[dxyXY]\d*"),
    ("load", r"F\d*"),
)
"""Symbols that only suggest what a column is."""

MEASURED_IN_ITS_OWN: Final = ("temperature", "displacement", "power", "load")
"""Quantities whose units suggest them."""

NOT_MEASURED: Final = {"setpoint", "target", "reference", "ref", "desired", "sp", "goal", "predicted", "model", "error"}
"""Words of columns that hold no measurement, whatever else their header says."""


def si_unit(quantity: str) -> str:
    """SI unit of a quantity, empty for an input that a user names (``input_fan``). Raises KeyError for another name."""
    return "s" if quantity == TIME else channel_named(quantity).unit


@dataclass(frozen=True)
class Meaning:
    """What a header says: the quantity, its unit if it names one, and whether words or only a symbol say so."""

    quantity: str
    unit: Unit | None
    certain: bool


def meaning(header: str) -> Meaning | None:
    """What a header says; None if nothing.

    Examples
    --------
    >>> meaning("displacement_mm").unit.symbol, meaning("T [°C]").quantity, meaning("T1").certain
    ('mm', 'temperature', False)
    """
    if header.startswith(NAMED_INPUT) and header.isidentifier() and header != NAMED_INPUT:
        return Meaning(header, channel_named(header).recorded, certain=True)
    name, unit_text = _apart(header)
    words = _words(name)
    if not words or NOT_MEASURED & {word.casefold() for word in words}:
        return None
    for quantity in (*WORDS, *(name for name in SI_UNITS if name not in WORDS)):
        known = WORDS.get(quantity, (quantity,))
        if quantity in SI_UNITS and {word.casefold() for word in words} & set(known):
            return Meaning(quantity, _unit(quantity, words, unit_text), certain=True)
    for quantity, symbol in LETTERS:
        if quantity in SI_UNITS and re.fullmatch(symbol, words[0]):
            unit = _unit(quantity, words, unit_text)
            if len(words) == 1 or unit is not None:
                return Meaning(quantity, unit, certain=unit is not None)
    return _by_unit(unit_text)


def _by_unit(text: str) -> Meaning | None:
    """What a unit alone suggests, behind a name that says nothing: ``IR camera [°C]`` is a temperature."""
    for quantity in MEASURED_IN_ITS_OWN:
        unit = find_unit(SI_UNITS[quantity], text)
        if unit is not None and unit.symbol != "%":
            return Meaning(quantity, unit, certain=False)
    return None


def _apart(header: str) -> tuple[str, str]:
    """The name, and the unit in brackets or behind a slash: ``T [°C]``, ``power (mW)``, ``d / mm``."""
    if found := re.search(r"[\[(]\s*([^\])]+?)\s*[\])]", header):
        return header[: found.start()], found[1]
    name, slash, unit = header.rpartition("/")
    return (name, unit.strip()) if slash and name else (header, "")


def _words(name: str) -> list[str]:
    """The words of a name, also where only capitals part them: ``laserPower_mW`` as laser, Power, mW."""
    parted = re.sub(r"(?<=[a-z])(?=[A-Z][a-z])", " ", name)
    return [word for word in re.split(r"[^\w°%µμ℃]+|_", parted) if word]


def _unit(quantity: str, words: list[str], text: str) -> Unit | None:
    """The unit in brackets, or the last word of the name if it is one."""
    if text:
        return find_unit(si_unit(quantity), text)
    return find_unit(si_unit(quantity), words[-1]) if len(words) > 1 else None
