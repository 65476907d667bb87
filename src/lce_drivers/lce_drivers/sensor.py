# SPDX-License-Identifier: Apache-2.0
"""Readings, what a sensor does on paper, and what a sensor device offers its node."""

from dataclasses import dataclass
from typing import Protocol


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
    """What a sensor does on paper; the simulated one does so unless parameters say otherwise.

    Parameters
    ----------
    rate_hz : readings a second [Hz]; infinite: one for each sample of the simulated strip.
    noise_rms : standard deviation of its noise [SI unit of the channel].
    quantum : step of its digits [SI unit of the channel], 0 for none.
    latency_s : from the acquisition to the reading [s].
    """

    rate_hz: float
    noise_rms: float
    quantum: float
    latency_s: float


class SensorDevice(Protocol):
    """A sensor behind its node. It hands its readings to the node that it was made with."""

    def fault(self) -> str | None:
        """What is wrong with the device at present, or None."""

    def close(self) -> None:
        """Let go of the device."""
