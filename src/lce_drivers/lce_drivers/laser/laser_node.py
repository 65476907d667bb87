# SPDX-License-Identifier: Apache-2.0
"""Node `laser`: the last word on laser power.

Subscribes  laser/power_command  std_msgs/Float64, W
            temperature          sensor_msgs/Temperature, °C; header.stamp is the time of measurement
Publishes   laser/power          std_msgs/Float64, W as applied, 100 Hz
Serves      laser/reset          std_srvs/Trigger: clears a fault, once its cause is gone
Parameters  max_power_w          W, upper limit of what is ever applied
            slew_w_per_s         W/s, fastest rise; 0: not limited
            command_timeout_s    s, maximum age of a command since it was published; an older one gives zero power
            temperature_required zero power without a thermal camera; false declares a bench that has no camera
            max_temperature_c    °C, above it: fault
            max_jump_k           K, more between two readings: fault
            temperature_pause_s  s, maximum age of a temperature; zero power from then until the next one
            temperature_fault_s  s, age of the newest temperature that is a fault while somebody commands
            device               simulated | labjack
            labjack.*            host, port, volts_per_watt, threshold_v, max_v, timeout_s, watchdog_s

The power is zero without a fresh, finite command, without a fresh temperature, from a fault of the temperature until
laser/reset, and on every way out of the process. After `kill -9` the node can do nothing more. Then the receiver of
the power sets it to zero: the simulator if laser/power is older than 100 ms, the hardware by its watchdog. A device
that cannot be written to ends the node with status 1.
"""

import sys
from collections.abc import Callable, Mapping
from typing import Any, Final

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from lce_data.channels import POWER, TEMPERATURE
from lce_data.topics import COMMAND
from lce_drivers.laser.clock_watch import QUIET_CHECKS, ClockWatch
from lce_drivers.laser.interlock import Interlock, TemperatureLimits
from lce_drivers.laser.labjack import Calibration, LabJackLaser, ModbusRegisters
from lce_drivers.laser.power_guard import PowerGuard, PowerLimits, PowerOutput, State
from lce_ros.conversions import from_stamp, to_kelvin
from lce_ros.health import Level
from lce_ros.node import LceNode, NodeFault, run

PERIOD_S: Final = 0.01
LAST_WORD_S: Final = 0.2
CLOCK_CHECK_S: Final = 0.1

LEVELS: Final = {
    State.WAITING: Level.OK,
    State.FOLLOWING: Level.OK,
    State.SLEWING: Level.OK,
    State.LIMITED: Level.WARN,
    State.STALE: Level.WARN,
    State.INVALID: Level.ERROR,
}


def simulated(node: LceNode) -> PowerOutput:
    """The laser of the simulated strip."""
    from lce_drivers.simulation.laser_output import SimulatedOutput

    return SimulatedOutput()


def labjack(node: LceNode) -> PowerOutput:
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
    try:
        return LabJackLaser(ModbusRegisters(host, port, timeout_s), calibration, watchdog_s)
    except OSError as error:
        raise NodeFault(f"laser: {error}") from error


DEVICES: Final[Mapping[str, Callable[[LceNode], PowerOutput]]] = {
    "simulated": simulated,
    "labjack": labjack,
}


class Laser(LceNode):
    """Applies the power that the guard and the interlock allow, 100 times a second."""

    def __init__(self, **options: Any) -> None:
        super().__init__("laser", **options)
        self.declare("max_power_w", 2.0, "upper limit of the power", unit="W", lower=0.0, upper=10.0)
        self.declare("slew_w_per_s", 0.0, "fastest rise; 0: not limited", unit="W/s", lower=0.0, upper=1e6)
        self.declare(
            "command_timeout_s",
            0.1,
            "maximum age of a command; an older one gives zero power",
            unit="s",
            lower=0.02,
            upper=1.0,
        )
        device = self.declare("device", "simulated", "what drives the laser", choices=tuple(DEVICES), read_only=True)
        self._output = DEVICES[device](self)
        self._guard = PowerGuard(self._limits())
        self._interlock = self._supervise()
        self._logged_fault: str | None = None
        self.add_post_set_parameters_callback(lambda _: self._follow_parameters())
        self._power = self.advertise(Float64, POWER.topic)
        self._closed = False
        self.listen(Float64, COMMAND, lambda m: self._guard.command(m.data, self.sent_s))
        self.listen(Temperature, TEMPERATURE.topic, self._take_temperature)
        self.create_service(Trigger, "laser/reset", self._reset)
        self.every(PERIOD_S, self._tick)
        self.every(1.0, self._look_for_rivals)
        if not self.on_sim_time:
            self._clock_watch = ClockWatch()
            self.create_timer(CLOCK_CHECK_S, self._check_clock, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def close(self) -> None:
        """Zero power: at the device first, then as the last word on laser/power."""
        if self._closed:
            return
        self._closed = True
        try:
            self._output.close()
        except OSError as error:
            # Only the device's watchdog can end the light now; to publish zero would be a guess.
            self.get_logger().error(f"zero power could not be set: {error}")
            return
        if self.context.ok():
            self._power.publish(Float64(data=0.0))
            self._power.wait_for_all_acked(Duration(seconds=LAST_WORD_S))

    def _tick(self) -> None:
        now_s = self.now_s()
        power_w = self._guard.power_w(self.tick_s, now_s)
        command_w = power_w if self._guard.commanded else None
        permitted = self._interlock is None or self._interlock.permits(now_s, command_w)
        if not permitted:
            power_w = self._guard.cut(now_s)
            self._log_fault()
        try:
            self._output.write(power_w)
        except OSError as error:
            raise NodeFault(f"laser: {error}") from error
        self._power.publish(Float64(data=power_w))
        self.report(*self._condition(permitted), power_w=power_w, invalid_commands=self._guard.invalid_commands)

    def _condition(self, permitted: bool) -> tuple[Level, str]:
        if permitted or self._interlock is None:
            return LEVELS[self._guard.state], self._guard.state.value
        if self._interlock.fault is None:
            return Level.WARN, "no fresh temperature: zero power"
        return Level.ERROR, f"fault: {self._interlock.fault}; zero power until laser/reset"

    def _log_fault(self) -> None:
        fault = None if self._interlock is None else self._interlock.fault
        if fault is not None and fault != self._logged_fault:
            self.get_logger().error(f"fault: {fault}; zero power until laser/reset")
        self._logged_fault = fault

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        fault = None if self._interlock is None else self._interlock.fault
        if self._interlock is None or fault is None:
            response.success, response.message = True, "there was no fault"
            return response
        obstacle = self._interlock.reset(self.now_s())
        response.success = obstacle is None
        response.message = f"cleared: {fault}" if obstacle is None else f"not cleared, {obstacle}: {fault}"
        if response.success:
            self.get_logger().warning(response.message)
        return response

    def _look_for_rivals(self) -> None:
        commanders = self.count_publishers(COMMAND)
        if commanders > 1:
            self.report(Level.WARN, f"{commanders} nodes command the laser at once")

    def _check_clock(self) -> None:
        if self._clock_watch.stopped(self.ticks):
            raise NodeFault(f"laser: no tick for {QUIET_CHECKS * CLOCK_CHECK_S:g} s: the system clock was set back")

    def _supervise(self) -> Interlock | None:
        def number(name: str, default: float, description: str, unit: str, lower: float, upper: float) -> None:
            self.declare(name, default, description, unit=unit, lower=lower, upper=upper)

        number("max_temperature_c", 120.0, "highest temperature of the strip; above it is a fault", "°C", -50.0, 300.0)
        number("max_jump_k", 10.0, "largest change between two temperatures; a larger one is a fault", "K", 0.1, 1000.0)
        number(
            "temperature_pause_s",
            0.2,
            "maximum age of a temperature; zero power from then until the next",
            "s",
            0.05,
            0.45,
        )
        number(
            "temperature_fault_s",
            0.5,
            "age of the newest temperature that is a fault while somebody commands",
            "s",
            0.46,
            5.0,
        )
        required = self.declare("temperature_required", True, "false: the bench has no thermal camera", read_only=True)
        return Interlock(self._temperature_limits()) if required else None

    def _temperature_limits(self) -> TemperatureLimits:
        numbers = (self.value(name) for name in ("max_jump_k", "temperature_pause_s", "temperature_fault_s"))
        return TemperatureLimits(to_kelvin(self.value("max_temperature_c")), *numbers)

    def _take_temperature(self, message: Temperature) -> None:
        if self._interlock is not None:
            self._interlock.read(to_kelvin(message.temperature), from_stamp(message.header.stamp))

    def _limits(self) -> PowerLimits:
        return PowerLimits(
            min(self.value("max_power_w"), self._output.max_power_w),
            self.value("command_timeout_s"),
            self.value("slew_w_per_s"),
        )

    def _follow_parameters(self) -> None:
        self._guard.limits = self._limits()
        if self._interlock is not None:
            self._interlock.limits = self._temperature_limits()


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(Laser, args)


if __name__ == "__main__":
    sys.exit(main())
