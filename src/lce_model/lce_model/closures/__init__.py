# SPDX-License-Identifier: Apache-2.0
"""Closures: an unknown function of one covariate, added at one place of the model.

They are effects that no library holds and that a search fills with numbers: :func:`closure` gives that of a place.
Its covariate (:mod:`.covariates`) and its form (:mod:`.forms`) are parameters, so that one compiled model serves every
function.
"""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from lce_model.effects import Effect, find


@dataclass(frozen=True)
class Place:
    """Where a function may be missing: its name, the unit of the function, and what people call it."""

    name: str
    unit: str
    words: str


PLACES: Final[tuple[Place, ...]] = (
    Place("light", "1", "the light"),
    Place("heat", "K/s", "the heat balance"),
    Place("order", "K", "the temperature of the order"),
    Place("strain", "m", "the strain"),
    Place("temperature_sensor", "K", "the camera"),
    Place("displacement_sensor", "m", "the distance sensor"),
)


@cache
def closure(place: str) -> Effect:
    """The closure of a place, by its name in PLACES."""
    return find(str(Path(__file__).with_name(f"{place}.py")))
