# SPDX-License-Identifier: Apache-2.0
"""Between the units of messages and the SI units inside, once, where data enter or leave a node."""

from builtin_interfaces.msg import Time

from lce_data.units import KELVIN


def to_kelvin(celsius: float) -> float:
    """Temperature [K] from a message's [°C]."""
    return celsius + KELVIN


def to_celsius(kelvin: float) -> float:
    """Temperature [°C], as sensor_msgs/Temperature wants it, from [K]."""
    return kelvin - KELVIN


def to_stamp(t_s: float) -> Time:
    """Stamp of a time [s] of the node clock, to the microsecond: a float of today's date resolves no more."""
    microseconds = round(t_s * 1e6)
    return Time(sec=microseconds // 1_000_000, nanosec=microseconds % 1_000_000 * 1000)


def from_stamp(stamp: Time) -> float:
    """Time [s] of a stamp."""
    return float(stamp.sec + stamp.nanosec * 1e-9)
