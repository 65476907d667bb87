# SPDX-License-Identifier: Apache-2.0
"""A signature: something that a residual shows, in words, as numbers, and as a small picture of itself."""

from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import Channel

Floats = NDArray[np.float64]
Name = Literal[
    "clipped",
    "rounded",
    "period",
    "step",
    "outliers",
    "follows",
    "differs_by_run",
    "drift",
    "variance",
    "both_sensors",
]
Shown = Literal["residual", "readings", "spectrum", "noise", "displacement"]
"""What the y of a picture is: a residual, readings beside the model, power over background, noise, a displacement."""

DISCOVER: Final = "`lce discover` looks for the place and the form of what is missing"
"""What to try where the library does not help."""
OF_SENSOR: Final = frozenset[Name]({"clipped", "rounded", "outliers"})
"""Signatures of a sensor: they say nothing about the strip."""
DISTURBANCES: Final = frozenset[Name]({"period"})
"""Signatures of something outside of the strip that acts on it, or on a sensor, by a clock of its own."""


@dataclass(frozen=True)
class Picture:
    """The arrays of a small picture, in SI units.

    title : what it shows.
    x_name, x_unit : of the quantity along x; ``x`` (n,) rises.
    shown : what is along y.
    curves : label to values (n,); NaN is a gap.
    points : label to values (n,) drawn as points.
    """

    title: str
    x_name: str
    x_unit: str
    x: Floats
    shown: Shown
    curves: dict[str, Floats]
    points: dict[str, Floats]


@dataclass(frozen=True)
class Signature:
    """Something that the residual of one sensor shows.

    name : which kind, from the catalogue.
    channel : the sensor.
    value, unit : the number that says most about it, in the unit that files use (°C, m, s).
    covariate : what the residual follows, by its name in ``lce_analysis.covariates``; None for all other kinds.
    p_value : chance of seeing it in a residual without it; 0 where thresholds decide.
    share : of the residual's energy in that sensor that it accounts for.
    words : a sentence.
    advice : what to try next, a sentence.
    picture : of itself.
    repeats : would it come again in another run of the same power? None if that is not known.
    """

    name: Name
    channel: Channel
    value: float
    unit: str
    covariate: str | None
    p_value: float
    share: float
    words: str
    advice: str
    picture: Picture
    repeats: bool | None = None

    @property
    def outside(self) -> bool:
        """Does it speak of a sensor, or of a disturbance from outside, and not of the physics of the strip?"""
        return self.name in OF_SENSOR | DISTURBANCES or (self.name == "both_sensors" and self.repeats is False)

    def as_json(self) -> dict[str, Any]:
        """The record of the contract."""
        return {
            "name": self.name,
            "sensor": self.channel.name,
            "value": self.value,
            "unit": self.unit,
            "covariate": self.covariate,
            "p_value": self.p_value,
            "words": self.words,
        }


def amount(channel: Channel, value: float) -> str:
    """A difference of readings [SI] as people say it: 0.21 K, 280 µm."""
    return f"{float(f'{value * channel.difference.factor:.2g}'):g} {channel.difference.symbol}"


def reading(channel: Channel, value: float) -> str:
    """A reading [SI] as people say it: 62.0 °C, 1.234 mm."""
    return f"{channel.display.from_si(value):.4g} {channel.display.symbol}"
