# SPDX-License-Identifier: Apache-2.0
"""Node `laser`: the last word on laser power.

Subscribes  laser/power_command  std_msgs/Float64, W
Publishes   laser/power          std_msgs/Float64, W as applied, 100 Hz
Parameters  max_power_w          W, upper limit of what is ever applied
            slew_w_per_s         W/s, fastest rise, 0 for no limit
            command_timeout_s    s, a command older than this counts as none
            device               simulated | labjack
            labjack.*            host, port, volts_per_watt, threshold_v, max_v, timeout_s, watchdog_s

Zero power without a fresh, finite command, and on every way out of the process. What no process can do for
itself after `kill -9` is done where the power arrives: the simulator takes a laser/power older than 100 ms
for zero, and the hardware's watchdog pulls its output to zero. A device that cannot be written ends the node
with status 1.
"""

import sys
from collections.abc import Callable, Mapping
from typing import Any, Final

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from std_msgs.msg import Float64

from lce_drivers.labjack import Calibration, LabJackLaser, ModbusRegisters
from lce_drivers.laser import PowerGuard, PowerLimits, PowerOutput, SimulatedOutput, State
from lce_ros.health import Level
from lce_ros.node import BenchNode, NodeFault, run

PERIOD_S: Final = 0.01
LAST_WORD_S: Final = 0.2
CLOCK_CHECK_S: Final = 0.2

LEVELS: Final = {
    State.WAITING: Level.OK,
    State.FOLLOWING: Level.OK,
    State.SLEWING: Level.OK,
    State.LIMITED: Level.WARN,
    State.STALE: Level.WARN,
    State.INVALID: Level.ERROR,
}


def labjack(node: BenchNode) -> PowerOutput:
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
        volts_per_watt=number("volts_per_watt", 0.0, "slope of the laser driver; to be set", "V/W", 0.0, 1000.0),
        threshold_v=number("threshold_v", 0.0, "voltage at which light begins", "V", 0.0, 10.0),
        max_v=number("max_v", 5.0, "highest voltage that is ever put out", "V", 0.0, 10.0),
    )
    try:
        return LabJackLaser(ModbusRegisters(host, port, timeout_s), calibration, watchdog_s)
    except OSError as error:
        raise NodeFault(f"laser: {error}") from error


DEVICES: Final[Mapping[str, Callable[[BenchNode], PowerOutput]]] = {
    "simulated": lambda node: SimulatedOutput(),
    "labjack": labjack,
}


class Laser(BenchNode):
    """Lets through what the guard allows, 100 times a second."""

    def __init__(self, **options: Any) -> None:
        super().__init__("laser", **options)
        self.declare("max_power_w", 2.0, "upper limit of the power", unit="W", lower=0.0, upper=10.0)
        self.declare("slew_w_per_s", 0.0, "fastest rise, 0: no limit", unit="W/s", lower=0.0, upper=1e6)
        self.declare("command_timeout_s", 0.1, "age at which a command is stale", unit="s", lower=0.02, upper=1.0)
        device = self.declare("device", "simulated", "what drives the laser", choices=tuple(DEVICES), read_only=True)
        self._output = DEVICES[device](self)
        self._guard = PowerGuard(self._limits())
        self.add_post_set_parameters_callback(lambda _: self._follow_parameters())
        self._power = self.advertise(Float64, "laser/power")
        self._closed = False
        self.listen(Float64, "laser/power_command", lambda m: self._guard.command(m.data, self.now_s()))
        self.every(PERIOD_S, self._tick)
        self.every(1.0, self._look_for_rivals)
        if not self.on_sim_time:
            self._seen_ticks = -1
            self.create_timer(CLOCK_CHECK_S, self._check_clock, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def close(self) -> None:
        """Zero power: at the device first, then as the last word on laser/power."""
        if self._closed:
            return
        self._closed = True
        try:
            self._output.close()
        except OSError as error:
            # What the strip gets is now the device's watchdog's to end; saying zero would be a guess.
            self.get_logger().error(f"zero power could not be set: {error}")
            return
        if self.context.ok():
            self._power.publish(Float64(data=0.0))
            self._power.wait_for_all_acked(Duration(seconds=LAST_WORD_S))

    def _tick(self) -> None:
        power_w = self._guard.power_w(self.tick_s, self.now_s())
        try:
            self._output.write(power_w)
        except OSError as error:
            raise NodeFault(f"laser: {error}") from error
        self._power.publish(Float64(data=power_w))
        state = self._guard.state
        self.report(LEVELS[state], state.value, power_w=power_w, invalid_commands=self._guard.invalid_commands)

    def _look_for_rivals(self) -> None:
        commanders = self.count_publishers("laser/power_command")
        if commanders > 1:
            self.report(Level.WARN, f"{commanders} nodes command the laser at once")

    def _check_clock(self) -> None:
        # Timers follow the node's clock: were it set back an hour, the laser would shine for an hour.
        if self.ticks == self._seen_ticks:
            raise NodeFault(f"laser: no tick for {CLOCK_CHECK_S:g} s: the system clock was set back")
        self._seen_ticks = self.ticks

    def _limits(self) -> PowerLimits:
        return PowerLimits(
            min(self.value("max_power_w"), self._output.max_power_w),
            self.value("command_timeout_s"),
            self.value("slew_w_per_s"),
        )

    def _follow_parameters(self) -> None:
        self._guard.limits = self._limits()


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(Laser, args)


if __name__ == "__main__":
    sys.exit(main())
