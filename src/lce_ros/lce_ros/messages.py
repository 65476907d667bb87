# SPDX-License-Identifier: Apache-2.0
"""How the values of a channel travel in messages. A new type of message is a row here; a new sensor adds no code."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_data.channels import NUMBER, STAMPED_NUMBER, Channel
from lce_interfaces.msg import Float64Stamped
from lce_ros.conversions import from_stamp, to_stamp

FRAME_ID: Final = "strip"


@dataclass(frozen=True)
class MessageKind:
    """A type of message that carries one number.

    Parameters
    ----------
    message : its class.
    write : the message of a value [recorded unit], the time of its measurement [s] and its variance.
    read : value [recorded unit] and time of measurement [s] of a message; the time is None if the type has no stamp.
    """

    message: type
    write: Callable[[float, float, float], Any]
    read: Callable[[Any], tuple[float, float | None]]


def _temperature(value: float, t_s: float, variance: float) -> Temperature:
    message = Temperature(temperature=value, variance=variance)
    message.header.stamp = to_stamp(t_s)
    message.header.frame_id = FRAME_ID
    return message


def stamped_number(value: float, t_s: float) -> Float64Stamped:
    """The message of a number that belongs to the time ``t_s`` [s]."""
    message = Float64Stamped(value=value)
    message.header.stamp = to_stamp(t_s)
    message.header.frame_id = FRAME_ID
    return message


KINDS: Final = {
    NUMBER: MessageKind(
        Float64,
        lambda value, t_s, variance: Float64(data=value),
        lambda message: (message.data, None),
    ),
    STAMPED_NUMBER: MessageKind(
        Float64Stamped,
        lambda value, t_s, variance: stamped_number(value, t_s),
        lambda message: (message.value, from_stamp(message.header.stamp)),
    ),
    "sensor_msgs/msg/Temperature": MessageKind(
        Temperature,
        _temperature,
        lambda message: (message.temperature, from_stamp(message.header.stamp)),
    ),
}


def message_class(channel: Channel) -> type:
    """The class of the messages on the channel's topic."""
    return KINDS[channel.message].message


def to_message(channel: Channel, value: float, t_s: float, variance: float = 0.0) -> Any:
    """The message of a value [SI] measured at ``t_s`` [s]; ``variance`` [SI] 0 means unknown, as in sensor_msgs."""
    return KINDS[channel.message].write(channel.recorded.from_si(value), t_s, variance)


def from_message(channel: Channel, message: Any) -> tuple[float, float | None]:
    """Value [SI] and time of measurement [s] of a message; the time is None if its type has no stamp."""
    value, t_s = KINDS[channel.message].read(message)
    return channel.recorded.to_si(value), t_s
