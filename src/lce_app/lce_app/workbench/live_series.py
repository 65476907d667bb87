# SPDX-License-Identifier: Apache-2.0
"""What a live plot can show: one number of the messages of a topic, with the name and the unit of its axis."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from lce_data.channels import (
    CHANNELS,
    DISPLACEMENT,
    NUMBER,
    POWER,
    SENSORS,
    STAMPED_NUMBER,
    TEMPERATURE,
    Channel,
    Unit,
)
from lce_data.topics import COMMAND, COMMAND_STAMPED, DIAGNOSTICS, RECORDED, SETPOINT, TARGET, simulated_topic
from lce_experiment.registry import NAMESPACE

WANTED: Final[Mapping[Channel, tuple[str, str]]] = {
    TEMPERATURE: (SETPOINT, "setpoint"),
    DISPLACEMENT: (TARGET, "target"),
    POWER: (COMMAND, "command"),
}
"""Topic and label of what is wanted of a channel, drawn beside what was measured."""
MONITORED: Final = (*(channel.topic for channel in (POWER, *SENSORS)), *(topic for topic, _ in WANTED.values()))
"""Topics whose values are shown."""

VALUE: Final = ("data", "value", "temperature")
"""Fields that are the value of a message, whose name adds nothing to that of the topic."""


@dataclass(frozen=True, order=True)
class Series:
    """A number in the messages of a topic.

    Parameters
    ----------
    topic : full name.
    path : of the field, such as ``temperature``, ``orientation.x`` or ``covariance[0]``; in /diagnostics the name of a
        condition and its key.
    """

    topic: str
    path: str

    @property
    def name(self) -> str:
        """How plots and lists call it."""
        topic = self.topic.removeprefix(f"{NAMESPACE}/")
        return topic if self.path in VALUE and self.topic != DIAGNOSTICS else f"{topic} {self.path}"

    @property
    def unit(self) -> Unit:
        """The unit in which it is drawn, and how it follows from the number in the message; "1" if none is known."""
        channel = _CHANNELS.get(self.topic.removeprefix(f"{NAMESPACE}/"))
        if channel is not None and self.path in VALUE:
            per_recorded = channel.display.factor / channel.recorded.factor
            offset = channel.display.offset - channel.recorded.offset * per_recorded
            return Unit(channel.display.symbol, per_recorded, offset)
        field = self.path.rpartition(".")[2]
        return Unit(_FIELDS.get(field) or _SUFFIXES.get(field.rpartition("_")[2], "1"))


@dataclass(frozen=True)
class TopicFields:
    """A topic of the graph, the type of its messages, and the paths of the numbers in them."""

    name: str
    type: str
    paths: tuple[str, ...]

    @property
    def series(self) -> tuple[Series, ...]:
        """What can be plotted of it."""
        return tuple(Series(self.name, path) for path in self.paths)


def series_of(channel: Channel) -> Series:
    """What was measured of a channel."""
    return Series(f"{NAMESPACE}/{channel.topic}", _PATHS[channel.message])


def recorded_series() -> Iterator[Series]:
    """What can be plotted of the topics that every bench has."""
    for topic, kind in RECORDED.items():
        if kind in _PATHS:
            yield Series(f"{NAMESPACE}/{topic}", _PATHS[kind])


def _channels() -> dict[str, Channel]:
    """The channel whose unit a topic has, by its name in the namespace."""
    found = {topic: channel for channel in CHANNELS for topic in (channel.topic, channel.stamped_topic) if topic}
    found |= {simulated_topic(channel): channel for channel in SENSORS}
    return found | {topic: channel for channel, (topic, _) in WANTED.items()} | {COMMAND_STAMPED: POWER}


_CHANNELS: Final[Mapping[str, Channel]] = _channels()
_PATHS: Final = {NUMBER: "data", STAMPED_NUMBER: "value", "sensor_msgs/msg/Temperature": "temperature"}
"""The value of a message, by its type."""
_FIELDS: Final = {
    "temperature": "°C",
    "fluid_pressure": "Pa",
    "illuminance": "lx",
    "voltage": "V",
    "current": "A",
}
"""Units of fields of sensor_msgs."""
_SUFFIXES: Final = {
    "k": "K",
    "c": "°C",
    "w": "W",
    "m": "m",
    "mm": "mm",
    "n": "N",
    "s": "s",
    "ms": "ms",
    "hz": "Hz",
    "v": "V",
    "a": "A",
    "pct": "%",
}
"""Units by the last word of a field's name, as in ``age_s``."""
