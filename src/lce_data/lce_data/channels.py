# SPDX-License-Identifier: Apache-2.0
"""The measured quantities of the bench, one object each.

Files, topics, fits, reports and the page ask a channel for what they need. A new sensor is a new entry here. A quantity
that only acts on the strip and that no entry describes is a column ``input_NAME`` of a CSV (:func:`named_input`).
"""

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final, TypeVar

from lce_data.units import KELVIN

if TYPE_CHECKING:  # nodes go by channel too, and most of them start without NumPy
    import numpy as np
    from numpy.typing import NDArray

Value = TypeVar("Value", float, "NDArray[np.float64]")

NUMBER: Final = "std_msgs/msg/Float64"
STAMPED_NUMBER: Final = "lce_interfaces/msg/Float64Stamped"
"""Types of messages of one number: without a time of its own, and with one."""


def stamped_topic(topic: str) -> str:
    """The topic beside one of plain numbers that carries the same numbers with their times."""
    return f"{topic}_stamped"


@dataclass(frozen=True)
class Unit:
    """A unit that people, files or messages use: value in it = factor × value in SI + offset."""

    symbol: str
    factor: float = 1.0
    offset: float = 0.0

    @property
    def is_si(self) -> bool:
        """Whether values in it are those in SI: an array is then passed on, not copied, for a run may have millions."""
        return self.factor == 1.0 and self.offset == 0.0

    def from_si(self, value: Value) -> Value:
        """A value in SI, or an array of them, in this unit."""
        return value if self.is_si else value * self.factor + self.offset

    def to_si(self, value: Value) -> Value:
        """A value in this unit, or an array of them, in SI."""
        return value if self.is_si else (value - self.offset) / self.factor


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
    sets : the signal of the model that an optional input sets, for the effects that read it; None for all others.
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
    sets: str | None = None
    largest_median: float = math.inf
    mistaken: tuple[float, float] | None = None
    csv_format: str = ".9g"
    digits: int = 3

    @property
    def column(self) -> str:
        """The column of a CSV, and the key of a JSON file, that holds it: ``temperature_c``."""
        return f"{self.name}_{self.suffix}" if self.suffix else self.name

    @property
    def stamped_topic(self) -> str | None:
        """The topic beside ``topic`` whose messages also tell the time of measurement; None if its own do."""
        return stamped_topic(self.topic) if self.message == NUMBER else None

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
    message=NUMBER,
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
    message=NUMBER,
    output="measured_displacement",
    driven_by=TEMPERATURE,
    noise=4e-6,
    lowest=-0.1,
    largest=0.1,
    csv_format=".9e",
    hint="is it in millimetres? Divide by 1000",
)

AMBIENT: Final = Channel(
    name="ambient",
    symbol="T_room",
    unit="K",
    recorded=Unit("°C", offset=-KELVIN),
    suffix="c",
    display=Unit("°C", offset=-KELVIN),
    difference=Unit("K"),
    topic="ambient_temperature",
    message="sensor_msgs/msg/Temperature",
    output=None,
    sets="room_temperature",
    driven_by=None,
    noise=0.0,
    lowest=-90.0,
    largest=200.0,
    csv_format=".6f",
    digits=2,
    hint=f"is it in kelvin? Subtract {KELVIN}",
)

LOAD: Final = Channel(
    name="load",
    symbol="F",
    unit="N",
    recorded=Unit("N"),
    suffix="n",
    display=Unit("N"),
    difference=Unit("mN", 1e3),
    topic="load",
    message=NUMBER,
    output=None,
    sets="load",
    driven_by=None,
    noise=0.0,
    lowest=-1e4,
    largest=1e4,
    hint="is it in millinewton? Divide by 1000",
)

CHANNELS: Final = (POWER, TEMPERATURE, DISPLACEMENT, AMBIENT, LOAD)
"""Every channel, in the order in which they stand in a CSV."""

SENSORS: Final = tuple(channel for channel in CHANNELS if channel.output is not None)
"""The channels that a model predicts, in the order of the chain P → T → d."""

INPUTS: Final = tuple(channel for channel in CHANNELS if channel.sets is not None)
"""The optional inputs: a run may lack them, and only the effects that read them need them."""

NAMED_INPUT: Final = "input_"
"""What the name, the column and the signal of an input that a user named begin with."""


@cache
def named_input(name: str) -> Channel:
    """The optional input of a user: a column ``input_NAME`` of a CSV in any unit, which an effect reads as is.

    Raises ValueError if the name does not begin with ``input_`` or is not an identifier.
    """
    if not name.startswith(NAMED_INPUT) or name == NAMED_INPUT or not name.isidentifier():
        raise ValueError(f"{name!r} is not {NAMED_INPUT}NAME, NAME of letters, digits and _")
    bare = Unit("")
    return Channel(
        name=name,
        symbol=name.removeprefix(NAMED_INPUT),
        unit="",
        recorded=bare,
        suffix="",
        display=bare,
        difference=bare,
        topic=f"input/{name.removeprefix(NAMED_INPUT)}",
        message=NUMBER,
        output=None,
        sets=name,
        driven_by=None,
        noise=0.0,
        lowest=-math.inf,
        largest=math.inf,
        hint="",
    )


def channel_named(name: str) -> Channel:
    """Look up a channel by its name. Raises KeyError if no channel has it."""
    known = {channel.name: channel for channel in CHANNELS}
    if name not in known:
        with suppress(ValueError):
            return named_input(name)
    return known[name]


def channel_of_column(column: str) -> Channel | None:
    """The channel that a column of a CSV holds, None if it holds none."""
    known = {channel.column: channel for channel in CHANNELS}
    if column not in known:
        with suppress(ValueError):
            return named_input(column)
    return known.get(column)


def in_order(channels: Iterable[Channel]) -> tuple[Channel, ...]:
    """The channels in the order in which they stand in a CSV: those of the table, then a user's inputs by name."""
    given = set(channels)
    return (*(c for c in CHANNELS if c in given), *sorted(given.difference(CHANNELS), key=lambda c: c.name))
