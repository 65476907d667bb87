# SPDX-License-Identifier: Apache-2.0
"""What the closures of all places have in common: their parameters."""

from typing import Final

from lce_model.closures.covariates import COVARIATES
from lce_model.closures.forms import FORMS, KNOTS
from lce_model.terms import Parameter

WIDE: Final = 1e12
"""Bound of a number whose size nobody knows before the data are there."""


def parameters(unit: str, knee: float) -> tuple[Parameter, ...]:
    """Of a closure whose function has this unit, and is of the size ``knee`` where it is just worth noticing."""
    source = "found in the data"

    def number(name: str, default: float, lower: float, upper: float, description: str) -> Parameter:
        return Parameter(name, "1", default, lower, upper, description, source, fixed=True)

    weights = tuple(
        Parameter(f"w_{i + 1}", unit, 0.0, -WIDE, WIDE, f"curve at knot {i + 1}", source, "asinh", knee, fixed=True)
        for i in range(KNOTS)
    )
    return (
        Parameter("strength", unit, 0.0, -WIDE, WIDE, "factor of the function", source, "asinh", knee),
        number("covariate", 0.0, 0.0, len(COVARIATES) - 1.0, "number of the covariate"),
        Parameter("tau", "s", 1.0, 1e-3, 1e4, "time constant of the lag", source, "log", fixed=True),
        number("form", 0.0, 0.0, float(len(FORMS)), "number of the form"),
        number("lower", 0.0, -WIDE, WIDE, "where the curve begins"),
        number("upper", 1.0, -WIDE, WIDE, "where the curve ends"),
        number("z0", 0.0, -WIDE, WIDE, "reference of the covariate"),
        Parameter("a", "1", 1.0, 1.0 / WIDE, WIDE, "first number of the form", source, "log", fixed=True),
        number("b", 0.0, -WIDE, WIDE, "second number of the form"),
        *weights,
    )
