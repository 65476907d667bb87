# SPDX-License-Identifier: Apache-2.0
"""The limits of the laser node as its parameters.

They are for the parameter file. Whoever can reach a running node could loosen them, so nobody can: they are read-only,
and the two that an operator may want to tighten, max_power_w and max_temperature_c, can only be lowered.
"""

from lce_drivers.laser.interlock import TemperatureLimits
from lce_drivers.laser.power_guard import PowerLimits
from lce_ros.conversions import to_kelvin
from lce_ros.node import LceNode


def declare_limits(node: LceNode) -> None:
    """Declare the parameters."""

    def number(name: str, default: float, description: str, unit: str, lower: float, upper: float) -> None:
        live = name in ("max_power_w", "max_temperature_c")
        node.declare(
            name, default, description, unit=unit, lower=lower, upper=upper, read_only=not live, only_lower=live
        )

    number("max_power_w", 2.0, "upper limit of the power", "W", 0.0, 10.0)
    number("slew_w_per_s", 0.0, "fastest rise; 0: not limited", "W/s", 0.0, 1e6)
    number("command_timeout_s", 0.1, "maximum age of a command; an older one gives zero power", "s", 0.02, 0.45)
    number("command_fault_s", 0.5, "age of a command for light that is a fault", "s", 0.46, 5.0)
    number("max_tick_gap_s", 0.1, "longest time between two ticks with the light on; above is a fault", "s", 0.03, 1.0)
    number("max_temperature_c", 120.0, "highest temperature of the strip; above it is a fault", "°C", -50.0, 300.0)
    number("min_temperature_c", -40.0, "lowest that the camera can measure; below it is a fault", "°C", -100.0, 50.0)
    number("max_jump_k", 10.0, "largest change between two temperatures; a larger one is a fault", "K", 0.1, 1000.0)
    number("temperature_pause_s", 0.2, "maximum age of a temperature; zero power until the next", "s", 0.05, 0.45)
    number("temperature_fault_s", 0.5, "age of a temperature that is a fault while somebody commands", "s", 0.46, 5.0)
    number(
        "frozen_after_s", 1.0, "light with the same temperature bit for bit that is a fault; 0: never", "s", 0.0, 60.0
    )


def power_limits(node: LceNode, device_w: float) -> PowerLimits:
    """Limits of the power; ``device_w`` [W] is the most that the device can give."""
    return PowerLimits(
        min(node.value("max_power_w"), device_w),
        node.value("command_timeout_s"),
        node.value("slew_w_per_s"),
        node.value("command_fault_s"),
    )


def no_temperature_left(lowest_c: float, highest_c: float) -> str | None:
    """What is wrong with limits [°C] that leave no temperature that is allowed; None if they leave one."""
    if highest_c > lowest_c:
        return None
    return f"max_temperature_c: {highest_c:g} °C is not above min_temperature_c, {lowest_c:g} °C"


def temperature_limits(node: LceNode) -> TemperatureLimits:
    """Limits of the temperature; raises ValueError where they leave none."""
    if (wrong := no_temperature_left(node.value("min_temperature_c"), node.value("max_temperature_c"))) is not None:
        raise ValueError(f"laser: {wrong}")
    return TemperatureLimits(
        to_kelvin(node.value("max_temperature_c")),
        to_kelvin(node.value("min_temperature_c")),
        node.value("max_jump_k"),
        node.value("temperature_pause_s"),
        node.value("temperature_fault_s"),
        node.value("frozen_after_s"),
    )
