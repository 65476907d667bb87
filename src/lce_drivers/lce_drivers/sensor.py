# SPDX-License-Identifier: Apache-2.0
"""Readings, the data sheet of a sensor, and what a sensor device and its node offer each other."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from lce_data.channels import Channel


@dataclass(frozen=True, slots=True)
class Reading:
    """A measured value.

    Parameters
    ----------
    value : [SI unit of the channel].
    t_s : time of its acquisition on the node's clock [s].
    variance : [SI unit squared]; 0 means unknown, as in sensor_msgs.
    """

    value: float
    t_s: float
    variance: float = 0.0


@dataclass(frozen=True, slots=True)
class DataSheet:
    """What its maker says of a sensor; the simulated one is like that unless parameters say otherwise.

    Parameters
    ----------
    rate_hz : readings a second [Hz]; infinite: one for each sample of the simulated strip.
    noise_rms : standard deviation of its noise [SI unit of the channel].
    quantum : step of its digits [SI unit of the channel]; 0: values are not rounded.
    latency_s : from the acquisition to the reading [s].
    """

    rate_hz: float
    noise_rms: float
    quantum: float
    latency_s: float


class SensorDevice(Protocol):
    """A sensor behind its node, opened."""

    def check(self) -> None:
        """Wait for a first reading. Raises OSError if none comes in the time that such a device takes to start."""

    def poll(self) -> Reading | None:
        """The newest reading, each at most once; always None from a device that hands its readings to the node."""

    def fault(self) -> str | None:
        """What is wrong with the device at present, or None."""

    def close(self) -> None:
        """Let go of the device."""


class DeviceNode(Protocol):
    """The node of a sensor, as a device that does not import it sees it (:class:`lce_drivers.sensor_node.SensorNode`).

    Attributes
    ----------
    channel : what the node measures.
    sheet : the data sheet of its sensor.
    sent_s : time [s] at which the message whose callback runs was published.
    """

    channel: Channel
    sheet: DataSheet
    sent_s: float

    def declare(
        self,
        name: str,
        default: Any,
        description: str,
        *,
        unit: str = "",
        lower: float | None = None,
        upper: float | None = None,
        read_only: bool = False,
    ) -> Any:
        """Declare a parameter and return its value."""

    def value(self, name: str) -> Any:
        """Present value of a declared parameter."""

    def add_post_set_parameters_callback(self, callback: Callable[[Any], None]) -> None:
        """Call back after parameters were set."""

    def listen(self, msg_type: Any, topic: str, callback: Callable[[Any], None]) -> Any:
        """Call back with each message of ``topic``."""

    def now_s(self) -> float:
        """Time [s] of the node's clock."""

    def deliver(self, reading: Reading) -> None:
        """Publish a reading while the node is active."""
