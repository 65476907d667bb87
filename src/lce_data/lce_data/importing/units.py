# SPDX-License-Identifier: Apache-2.0
"""Units in which foreign files hold time and channels, by the SI unit of the quantity, and how people spell them."""

from __future__ import annotations

from typing import Final

from lce_data.channels import Unit
from lce_data.errors import LceError
from lce_data.units import KELVIN

CELSIUS: Final = Unit("°C", offset=-KELVIN)
GRAVITY: Final = 9.80665
"""Standard acceleration of free fall [m/s²]."""

SPELLINGS: Final[dict[str, dict[Unit, tuple[str, ...]]]] = {
    "s": {
        Unit("s"): ("s", "sec", "secs", "second", "seconds"),
        Unit("ms", 1e3): ("ms", "msec", "millis", "millisecond", "milliseconds"),
        Unit("µs", 1e6): ("µs", "us", "usec", "micros", "microsecond", "microseconds"),
        Unit("ns", 1e9): ("ns", "nsec", "nanos", "nanosecond", "nanoseconds"),
        Unit("min", 1.0 / 60.0): ("min", "mins", "minute", "minutes"),
        Unit("h", 1.0 / 3600.0): ("h", "hr", "hrs", "hour", "hours"),
    },
    "W": {
        Unit("W"): ("w", "watt", "watts"),
        Unit("mW", 1e3): ("mw", "milliwatt", "milliwatts"),
        Unit("µW", 1e6): ("µw", "uw", "microwatt"),
        Unit("kW", 1e-3): ("kw", "kilowatt"),
        Unit("%", 100.0): ("%", "pct", "percent", "perc"),
    },
    "K": {
        CELSIUS: ("°c", "c", "degc", "deg c", "deg_c", "celsius", "℃"),
        Unit("K"): ("k", "kelvin", "degk", "°k"),
        Unit("°F", 1.8, 32.0 - 1.8 * KELVIN): ("°f", "f", "degf", "deg f", "fahrenheit"),
    },
    "m": {
        Unit("m"): ("m", "meter", "meters", "metre", "metres"),
        Unit("mm", 1e3): ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
        Unit("µm", 1e6): ("µm", "um", "micron", "microns", "micrometer", "micrometers"),
        Unit("cm", 1e2): ("cm", "centimeter", "centimetre"),
        Unit("nm", 1e9): ("nm", "nanometer", "nanometre"),
        Unit("in", 1.0 / 0.0254): ("in", "inch", "inches"),
        Unit("%", 1e3): ("%", "pct", "percent", "perc"),
    },
    "N": {
        Unit("N"): ("n", "newton", "newtons"),
        Unit("mN", 1e3): ("mn", "millinewton"),
        Unit("g", 1e3 / GRAVITY): ("g", "gf", "gram", "grams"),
        Unit("kg", 1.0 / GRAVITY): ("kg", "kgf"),
        Unit("MPa"): ("mpa", "n/mm2", "n/mm²"),
    },
}
"""The first unit of each quantity is the one that a file most likely has."""

MEANING: Final = {
    ("W", "%"): "100 % counts as 1 W: gains are in K per full power",
    ("m", "%"): "1 % counts as 1 mm: the strain of 100 mm",
    ("N", "MPa"): "1 MPa counts as 1 N: the force on a cross-section of 1 mm²",
}
"""The remark on a unit that is no unit of the quantity, by SI unit and symbol."""


def typed(unit: Unit) -> str:
    """A unit as it is typed on any keyboard: ``degC``, ``um``."""
    return unit.symbol.replace("°", "deg").replace("µ", "u")


def units_of(si_unit: str) -> dict[Unit, tuple[str, ...]]:
    """Units of a quantity, by its SI unit, with their spellings in small letters."""
    return SPELLINGS.get(si_unit, {Unit(si_unit): (si_unit.casefold(),)})


def find_unit(si_unit: str, text: str) -> Unit | None:
    """The unit of a quantity that is spelt so; None if no unit is."""
    spelt = text.strip().casefold().replace("μ", "µ")  # Greek mu, as str.casefold makes of the micro sign
    for unit, spellings in units_of(si_unit).items():
        if spelt in (s.casefold().replace("μ", "µ") for s in (unit.symbol, *spellings)):
            return unit
    return None


def unit_and_sign(si_unit: str, text: str) -> tuple[Unit, float]:
    """A unit as typed by hand, and its sign, which a minus in front flips: ``-mm``. Raises LceError for another one."""
    sign = -1.0 if text.startswith("-") else 1.0
    unit = find_unit(si_unit, text.removeprefix("-"))
    if unit is None:
        known = ", ".join(u.symbol for u in units_of(si_unit))
        raise LceError(
            f"{text!r} is not a unit that is known here; one of {known}, with a minus in front to flip the sign"
        )
    return unit, sign
