# SPDX-License-Identifier: Apache-2.0
"""From the counts of a radiometric camera to the temperature of the strip; NumPy only.

FLIR A3x5 and A6x5 send Mono16 frames that are linear in temperature: 0.01 K per count (TemperatureLinear10mK)
or 0.1 K per count (TemperatureLinear100mK), from 0 K.
"""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint16]
ByteOrder = Literal["little", "big"]
Statistic = Literal["mean", "median", "max"]

KELVIN_PER_COUNT: Final = {"TemperatureLinear10mK": 0.01, "TemperatureLinear100mK": 0.1}
STATISTICS: Final = ("mean", "median", "max")
BYTE_ORDERS: Final = ("little", "big")


@dataclass(frozen=True, slots=True)
class Region:
    """Part of the frame [pixels]; a width or height of 0 reaches to the edge."""

    x: int = 0
    y: int = 0
    width: int = 0
    height: int = 0

    def __post_init__(self) -> None:
        for name in self.__slots__:
            if getattr(self, name) < 0:
                raise ValueError(f"region {name}: {getattr(self, name)} is negative")

    def crop(self, frame: Frame) -> Frame:
        """The part of a frame (h, w). Raises ValueError if the region is not within the frame."""
        height, width = frame.shape
        right = self.x + self.width if self.width else width
        bottom = self.y + self.height if self.height else height
        if not (self.x < right <= width and self.y < bottom <= height):
            raise ValueError(
                f"region x {self.x}..{right}, y {self.y}..{bottom} is not within {width} x {height} pixels"
            )
        return frame[self.y : bottom, self.x : right]


def decode_mono16(data: bytes, width: int, height: int, byte_order: ByteOrder) -> Frame:
    """Counts (height, width) of a Mono16 buffer. Raises ValueError if its size does not fit."""
    if len(data) != 2 * width * height:
        raise ValueError(f"a Mono16 frame of {width} x {height} has {2 * width * height} bytes, not {len(data)}")
    counts = np.frombuffer(data, dtype="<u2" if byte_order == "little" else ">u2")
    return counts.astype(np.uint16).reshape(height, width)


def to_kelvin(counts: NDArray[np.uint16], kelvin_per_count: float) -> NDArray[np.float64]:
    """Temperature [K] of counts, any shape."""
    return counts.astype(np.float64) * kelvin_per_count


def strip_temperature_k(counts: Frame, kelvin_per_count: float, statistic: Statistic) -> float:
    """One temperature [K] for the strip: the statistic of the counts (h, w) of its region."""
    return float(getattr(np, statistic)(counts)) * kelvin_per_count


def implausible(counts: Frame, kelvin_per_count: float, lower_k: float, upper_k: float) -> str | None:
    """Why the counts (h, w) cannot be temperatures within [lower_k, upper_k] [K]; None if they can.

    The median is judged, so a hot pixel is no fault. Some cameras send Mono16 with its bytes swapped: if swapping would
    help, the sentence says so.
    """
    median_k = float(np.median(counts)) * kelvin_per_count
    if lower_k <= median_k <= upper_k:
        return None
    swapped_k = float(np.median(counts.byteswap())) * kelvin_per_count
    hint = "; with its bytes swapped it is: change byte_order" if lower_k <= swapped_k <= upper_k else ""
    return f"a median of {median_k:.1f} K is not within [{lower_k:g}, {upper_k:g}] K{hint}"
