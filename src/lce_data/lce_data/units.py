# SPDX-License-Identifier: Apache-2.0
"""Units: values are in SI units throughout; what people and messages see is converted once, here."""

from typing import Final

KELVIN: Final[float] = 273.15
"""0 °C in kelvin."""
