# SPDX-License-Identifier: Apache-2.0
"""Parameters that differ from run to run: a value for each run, drawn around the value in the model.

value_i ~ N(value in the model, spread²): a random effect (Laird and Ware 1982). A run that says little of a parameter
is drawn towards the value in the model; a run that is not listed has that value.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class RunValue:
    """The value of a parameter in one run, and its standard error (None if not known), in the unit of the parameter."""

    value: float
    standard_error: float | None = None


@dataclass(frozen=True, slots=True)
class Variation:
    """How a parameter differs from run to run.

    Attributes
    ----------
    spread : standard deviation between runs, in the unit of the parameter; None before a fit.
    by_run : its value in each run, by the name of the run.
    """

    spread: float | None = None
    by_run: Mapping[str, RunValue] = field(default_factory=lambda: MappingProxyType({}))
