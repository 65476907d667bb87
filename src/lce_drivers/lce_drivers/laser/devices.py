# SPDX-License-Identifier: Apache-2.0
"""What drives the laser, by the parameter ``device`` of its node. Another device: a row of ``DEVICES``."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from lce_drivers.laser.labjack import Calibration, LabJackLaser
from lce_drivers.laser.modbus import ModbusRegisters
from lce_drivers.laser.power_guard import PowerOutput
from lce_ros.node import LceNode, NodeFault


@dataclass(frozen=True, slots=True)
class LaserDevice:
    """A device that can be opened.

    Parameters
    ----------
    what : which device, for the log and as the hardware_id of /diagnostics.
    makes_light : whether there is real light, which only a human may arm.
    open : opens the device, checks it and leaves it at zero power. Raises NodeFault if it is not there or not as it
        should be.
    """

    what: str
    makes_light: bool
    open: Callable[[], PowerOutput]


def simulated(node: LceNode) -> LaserDevice:
    """The laser of the simulated strip."""
    from lce_drivers.simulation.laser_output import SimulatedOutput

    return LaserDevice("simulated", False, SimulatedOutput)


def labjack(node: LceNode) -> LaserDevice:
    """A laser driver behind the analogue output of a LabJack T7 or T8."""
    if node.on_sim_time:
        raise ValueError("laser: a real laser does not run on simulated time; set use_sim_time to false")

    def number(name: str, default: float, description: str, unit: str, lower: float, upper: float) -> float:
        value: float = node.declare(
            f"labjack.{name}", default, description, unit=unit, lower=lower, upper=upper, read_only=True
        )
        return value

    host = node.declare("labjack.host", "192.168.1.207", "address of the LabJack", read_only=True)
    port = node.declare("labjack.port", 502, "Modbus TCP port", lower=1, upper=65535, read_only=True)
    watchdog_s = node.declare(
        "labjack.watchdog_s", 2, "the device's own watchdog", unit="s", lower=2, upper=60, read_only=True
    )
    timeout_s = number("timeout_s", 0.1, "longest wait for an answer", "s", 0.01, 1.0)
    calibration = Calibration(
        volts_per_watt=number("volts_per_watt", 0.0, "slope of the laser driver; must be set", "V/W", 0.0, 1000.0),
        threshold_v=number("threshold_v", 0.0, "voltage at which light begins", "V", 0.0, 10.0),
        max_v=number("max_v", 5.0, "highest voltage that is ever put out", "V", 0.0, 10.0),
    )

    def opened() -> PowerOutput:
        try:
            return LabJackLaser(ModbusRegisters(host, port, timeout_s), calibration, watchdog_s)
        except OSError as error:
            raise NodeFault(f"laser: {error}") from error

    return LaserDevice(f"labjack {host}:{port}", True, opened)


DEVICES: Final[Mapping[str, Callable[[LceNode], LaserDevice]]] = {
    "simulated": simulated,
    "labjack": labjack,
}
