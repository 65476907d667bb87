# SPDX-License-Identifier: Apache-2.0
"""The measured quantities of the bench, one object each.

Files, topics, fits, reports and the page ask a channel for what they need. A new sensor is a new entry here.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

from lce_data.units import KELVIN

if TYPE_CHECKING:  # nodes go by channel too, and most of them start without NumPy
    import numpy as np
    from numpy.typing import NDArray

Value = TypeVar("Value", float, "NDArray[np.float64]")


@dataclass(frozen=True)
class Unit:
    """A unit that people, files or messages use: value in it = factor × value in SI + offset."""

    symbol: str
    factor: float = 1.0
    offset: float = 0.0

    def from_si(self, value: Value) -> Value:
        """A value in SI, or an array of them, in this unit."""
        return value * self.factor + self.offset

    def to_si(self, value: Value) -> Value:
        """A value in this unit, or an array of them, in SI."""
        return (value - self.offset) / self.factor


@dataclass(frozen=True, eq=False, repr=False)
class Channel:
    """A quantity that is measured over time.

    There is one object of each, and unpickling returns that one: compare channels with ``is``.

    Parameters
    ----------
    name : how code, JSON and the page call it.
    symbol : in tables and sentences.
    unit : of its values in code, always SI.
    recorded : unit in messages, CSV and JSON; ``suffix`` names it in columns and keys (``temperature_c``).
    display : unit of axes.
    difference : unit in which two values are compared, on axes of residuals and in sentences.
    topic : relative to the namespace of the bench.
    message : type of its messages. A type that no channel has yet needs two rows, one in ``KINDS``
        (:mod:`lce_ros.messages`) for the nodes and one in ``NUMBERS`` (:mod:`lce_data.bag.reader`) for bags.
    output : the signal of the model that says what this sensor shows; None for an input of the model.
    driven_by : the channel before it in the chain P → T → d; None for an input of the model.
    noise : standard deviation of the bench's sensor [SI], for experiments that are only designed.
    lowest, largest : range of the values of a recording [recorded unit].
    hint : what to do about a recording outside of that range.
    largest_median : limit of the median of a recording [recorded unit], for a sensor whose single readings may be wild.
    mistaken : a recording that stays within this range, but for one reading in twenty below it, is in another unit
        [recorded unit].
    csv_format : format of a value in a CSV [recorded unit].
    digits : significant digits of a difference in a sentence.
    """

    name: str
    symbol: str
    unit: str
    recorded: Unit
    suffix: str
    display: Unit
    difference: Unit
    topic: str
    message: str
    output: str | None
    driven_by: "Channel | None"
    noise: float
    lowest: float
    largest: float
    hint: str
    largest_median: float = math.inf
    mistaken: tuple[float, float] | None = None
    csv_format: str = ".9g"
    digits: int = 3

    @property
    def column(self) -> str:
        """The column of a CSV, and the key of a JSON file, that holds it: ``temperature_c``."""
        return f"{self.name}_{self.suffix}"

    def __repr__(self) -> str:
        return f"<channel {self.name} [{self.unit}]>"

    def __reduce__(self) -> tuple[Callable[[str], "Channel"], tuple[str]]:
        return channel_named, (self.name,)


POWER: Final = Channel(
    name="power",
    symbol="P",
    unit="W",
    recorded=Unit("W"),
    suffix="w",
    display=Unit("W"),
    difference=Unit("W"),
    topic="laser/power",
    message="std_msgs/msg/Float64",
    output=None,
    driven_by=None,
    noise=0.0,
    lowest=0.0,
    largest=math.inf,
    hint="a laser gives 0 W or more",
)

TEMPERATURE: Final = Channel(
    name="temperature",
    symbol="T",
    unit="K",
    recorded=Unit("°C", offset=-KELVIN),
    suffix="c",
    display=Unit("°C", offset=-KELVIN),
    difference=Unit("K"),
    topic="temperature",
    message="sensor_msgs/msg/Temperature",
    output="measured_temperature",
    driven_by=POWER,
    noise=0.06,
    lowest=-KELVIN,
    largest=math.inf,
    largest_median=1500.0,
    mistaken=(250.0, 400.0),
    csv_format=".6f",
    digits=2,
    hint=f"is it in kelvin? Subtract {KELVIN}",
)

DISPLACEMENT: Final = Channel(
    name="displacement",
    symbol="d",
    unit="m",
    recorded=Unit("m"),
    suffix="m",
    display=Unit("mm", 1e3),
    difference=Unit("µm", 1e6),
    topic="displacement",
    message="std_msgs/msg/Float64",
    output="measured_displacement",
    driven_by=TEMPERATURE,
    noise=4e-6,
    lowest=-0.1,
    largest=0.1,
    csv_format=".9e",
    hint="is it in millimetres? Divide by 1000",
)

CHANNELS: Final = (POWER, TEMPERATURE, DISPLACEMENT)
"""Every channel, in the order in which they stand in a CSV."""

SENSORS: Final = tuple(channel for channel in CHANNELS if channel.output is not None)
"""The channels that a model predicts, in the order of the chain P → T → d."""


def channel_named(name: str) -> Channel:
    """Look up a channel by its name. Raises KeyError if no channel has it."""
    return {channel.name: channel for channel in CHANNELS}[name]
