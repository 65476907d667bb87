# SPDX-License-Identifier: Apache-2.0
"""Units: values are in SI units throughout; what people and messages see is converted once, here."""

from typing import Final

KELVIN: Final[float] = 273.15
"""0 °C in kelvin."""


def after_number(unit: str) -> str:
    """What stands behind a number: a space and its unit, nothing if it is dimensionless ("1")."""
    return "" if unit == "1" else f" {unit}"


def in_head(name: str, unit: str) -> str:
    """The head of a column: "tau [s]", or the name alone if its values are dimensionless ("1")."""
    return name if unit == "1" else f"{name} [{unit}]"
