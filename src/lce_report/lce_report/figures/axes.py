# SPDX-License-Identifier: Apache-2.0
"""Axes and units of a channel, for every figure and table that shows one."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import Channel
from lce_report.blocks import Axis

Floats = NDArray[np.float64]

TIME: Final = Axis("time", "s")
RATE: Final = Axis("dT/dt", "K/s")


def value_axis(channel: Channel) -> Axis:
    """Axis of a channel's values, in its display unit: T [°C]."""
    return Axis(channel.symbol, channel.display.symbol)


def residual_axis(channel: Channel) -> Axis:
    """Axis of measured minus modelled, in the channel's unit of differences: residual T [K]."""
    return Axis(f"residual {channel.symbol}", channel.difference.symbol)


def title(channel: Channel) -> str:
    """Name and symbol, which no line break parts: temperature T."""
    return f"{channel.name}\u00a0{channel.symbol}"


def displayed(channel: Channel, recorded: Floats) -> Floats:
    """Values in the channel's recorded unit, as comparisons hold them, in its display unit."""
    return channel.display.from_si(channel.recorded.to_si(recorded))


def difference_scale(channel: Channel) -> float:
    """Factor from a difference in the channel's recorded unit to one in its unit of differences (m → µm: 1e6)."""
    return channel.difference.factor / channel.recorded.factor
