# SPDX-License-Identifier: Apache-2.0
"""Node `laser`: the last word on laser power.

Subscribes  laser/power_command  std_msgs/Float64, W
            temperature          sensor_msgs/Temperature, °C; header.stamp is the time of measurement
Publishes   laser/power          std_msgs/Float64, W as applied, 100 Hz
            laser/armed          std_msgs/Bool, latched, on change: whether light is allowed
Serves      laser/arm            std_srvs/SetBool: true arms, without a fault and while zero is commanded; false disarms
            laser/reset          std_srvs/Trigger: clears a fault, once its cause is gone; disarmed then
Parameters  max_power_w          W, upper limit of what is ever applied
            slew_w_per_s         W/s, fastest rise; 0: not limited
            command_timeout_s    s, maximum age of a command since it was published; an older one gives zero power
            command_fault_s      s, age of a command for light at which the silence after it is a fault
            max_tick_gap_s       s, longest time between two ticks with the light on; a longer one is a fault
            temperature_required zero power without a thermal camera; false declares a bench that has no camera
            max_temperature_c    °C, above it: fault
            min_temperature_c    °C, below it, the lowest of the camera's data sheet: fault
            max_jump_k           K, more between two readings: fault
            temperature_pause_s  s, maximum age of a temperature; zero power from then until the next one
            temperature_fault_s  s, age of the newest temperature that is a fault while somebody commands
            frozen_after_s       s, light with the same temperature bit for bit: fault; 0 for a camera without noise
            arm_at_start         armed when the node starts; a device that makes light refuses it
            device               simulated | labjack
            labjack.*            host, port, volts_per_watt, threshold_v, max_v, timeout_s, watchdog_s

All parameters are read-only; max_power_w and max_temperature_c can be lowered.

The power is zero unless the node is armed, without a fresh, finite command, without a fresh temperature, from a fault
until laser/reset and laser/arm, and on every way out of the process. Faults are those of the parameters, a second
publisher of commands or temperatures, and a device that is not as it was left. After `kill -9` the node can do nothing
more. Then the receiver of the power sets it to zero: the simulator if laser/power is older than 100 ms, the hardware by
its watchdog. A device that does not answer ends the node with status 1. The states: docs/safety.md.
"""

import sys
from contextlib import ExitStack
from typing import Any, Final

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from sensor_msgs.msg import Temperature
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger

from lce_data.channels import POWER, TEMPERATURE
from lce_data.topics import ARMED, COMMAND
from lce_drivers.laser.arming import Arming
from lce_drivers.laser.clock_watch import QUIET_CHECKS, ClockWatch, StallWatch
from lce_drivers.laser.devices import DEVICES
from lce_drivers.laser.interlock import Interlock
from lce_drivers.laser.laser_limits import declare_limits, power_limits, temperature_limits
from lce_drivers.laser.power_guard import PowerGuard, State
from lce_drivers.laser.sole_source import SoleSource
from lce_ros.conversions import from_stamp, to_kelvin
from lce_ros.domain import only_laser
from lce_ros.health import Level
from lce_ros.node import LceNode, NodeFault, run

PERIOD_S: Final = 0.01
LAST_WORD_S: Final = 0.2
CLOCK_CHECK_S: Final = 0.1
DEVICE_CHECK_S: Final = 1.0

LEVELS: Final = {
    State.WAITING: Level.OK,
    State.FOLLOWING: Level.OK,
    State.SLEWING: Level.OK,
    State.LIMITED: Level.WARN,
    State.STALE: Level.WARN,
    State.INVALID: Level.ERROR,
    State.AHEAD: Level.ERROR,
}


class Laser(LceNode):
    """Applies the power that the guard and the interlock allow while it is armed, 100 times a second."""

    def __init__(self, **options: Any) -> None:
        super().__init__("laser", **options)
        declare_limits(self)
        device = self.declare("device", "simulated", "what drives the laser", choices=tuple(DEVICES), read_only=True)
        required = self.declare("temperature_required", True, "false: the bench has no thermal camera", read_only=True)
        self._output = DEVICES[device](self)
        self._guard = PowerGuard(power_limits(self, self._output.max_power_w))
        self._interlock = Interlock(temperature_limits(self)) if required else None
        self._sources = {topic: SoleSource(topic) for topic in (COMMAND, TEMPERATURE.topic)}
        self._arming = Arming(self._armed_at_start())
        self._told: tuple[bool, str | None] | None = None
        self._told_s = 0.0
        self._power_w = 0.0
        self._closed = False
        self.add_post_set_parameters_callback(lambda _: self._follow_parameters())
        self._power = self.advertise(Float64, POWER.topic)
        self._armed = self.advertise(Bool, ARMED, latched=True)
        self.listen(Float64, COMMAND, self._take_command)
        self.listen(Temperature, TEMPERATURE.topic, self._take_temperature)
        self.create_service(SetBool, "laser/arm", self._arm)
        self.create_service(Trigger, "laser/reset", self._reset)
        self.every(PERIOD_S, self._tick)
        self.every(DEVICE_CHECK_S, self._look_around)
        if not self.on_sim_time:
            self._clock_watch, self._stall_watch = ClockWatch(), StallWatch(self.value("max_tick_gap_s"))
            self._steady = Clock(clock_type=ClockType.STEADY_TIME)
            self.create_timer(CLOCK_CHECK_S, self._check_clock, clock=self._steady)

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

    def _armed_at_start(self) -> bool:
        real = self._output.makes_light
        armed: bool = self.declare("arm_at_start", not real, "armed when the node starts", read_only=True)
        if armed and real:
            self._output.close()
            raise ValueError("laser: arm_at_start: a laser that makes light is armed by laser/arm alone")
        return armed

    def _tick(self) -> None:
        now_s = self.now_s()
        if not self.on_sim_time:
            self._check_stall()
        wanted_w = self._guard.power_w(self.tick_s, now_s)
        self._judge(now_s, wanted_w)
        cold = self._interlock is not None and wanted_w > 0.0 and not self._interlock.is_fresh(now_s)
        self._power_w = self._guard.cut(now_s) if cold or not self._arming.armed else wanted_w
        try:
            self._output.write(self._power_w)
        except OSError as error:
            raise NodeFault(f"laser: {error}") from error
        self._power.publish(Float64(data=self._power_w))
        self._tell_arming()
        self.report(
            *self._condition(wanted_w, cold), power_w=self._power_w, invalid_commands=self._guard.invalid_commands
        )

    def _judge(self, now_s: float, wanted_w: float) -> None:
        """Latch what is wrong with command and temperature."""
        armed = self._arming.armed
        if armed:
            self._arming.latch(self._guard.fault(now_s))
            if self._output.makes_light and self._guard.abandoned(now_s):
                self._arming.disarm()  # whoever commands next has to be let in by somebody
        if self._interlock is not None:
            wanted = None if not self._guard.commanded else wanted_w if armed else 0.0
            self._arming.latch(self._interlock.judge(now_s, wanted))

    def _check_stall(self) -> None:
        stall = self._stall_watch.tick(self._steady.now().nanoseconds * 1e-9, self._power_w > 0.0)
        if stall is not None:
            self._arming.latch(stall)
            self._arming.latch(self._mismatch())

    def _mismatch(self) -> str | None:
        try:
            return self._output.mismatch()
        except OSError as error:
            raise NodeFault(f"laser: {error}") from error

    def _tell_arming(self) -> None:
        """Publish and log a change of the state."""
        arming = self._arming
        before, self._told = self._told, (arming.armed, arming.fault)
        if before == self._told:
            return
        if before is None or before[0] != arming.armed:
            self._armed.publish(Bool(data=arming.armed))
            self._told_s = self.now_s()
        if arming.fault is not None:
            self.get_logger().error(f"fault: {arming.fault}; zero power until laser/reset and laser/arm")
        elif before is not None or not arming.armed:
            self.get_logger().warning("armed" if arming.armed else "disarmed: zero power until laser/arm")

    def _condition(self, wanted_w: float, cold: bool) -> tuple[Level, str]:
        arming = self._arming
        if arming.fault is not None:
            return Level.ERROR, f"fault: {arming.fault}; zero power until laser/reset and laser/arm"
        if not arming.armed:
            return Level.WARN if wanted_w > 0.0 else Level.OK, "disarmed: zero power until laser/arm"
        if cold:
            return Level.WARN, "no fresh temperature: zero power"
        return LEVELS[self._guard.state], self._guard.state.value

    def _arm(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if not request.data:
            self._arming.disarm()
            response.success, response.message = True, "disarmed"
            return response
        now_s, before = self.now_s(), self._arming.armed
        told_s = now_s - self._told_s if self._told is not None and not self._told[0] else 0.0
        refusal = self._arming.arm(self._guard.commanded_w(now_s), told_s)
        if self._arming.armed and not before:
            # What was commanded until now belongs to the time before.
            self._guard.forget()
        response.success, response.message = refusal is None, "armed" if refusal is None else f"not armed: {refusal}"
        return response

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = self._arming.reset(self._obstacle(self.now_s()))
        response.success = self._arming.fault is None
        return response

    def _obstacle(self, now_s: float) -> str | None:
        """What forbids a reset: any cause that is there now, whatever caused the fault."""
        obstacles = [source.obstacle(now_s) for source in self._sources.values()]
        if self._interlock is not None:
            obstacles.append(self._interlock.obstacle(now_s))
        obstacles.append(self._mismatch())
        return next((obstacle for obstacle in obstacles if obstacle is not None), None)

    def _look_around(self) -> None:
        self._arming.latch(self._mismatch())
        for topic in self._sources:
            publishers = self.count_publishers(topic)
            if publishers > 1:
                self.report(Level.WARN, f"{publishers} nodes could publish {topic}")

    def _check_clock(self) -> None:
        if self._clock_watch.stopped(self.ticks):
            raise NodeFault(f"laser: no tick for {QUIET_CHECKS * CLOCK_CHECK_S:g} s: the system clock was set back")

    def _take_command(self, message: Float64) -> None:
        now_s = self.now_s()
        self._arming.latch(self._sources[COMMAND].heard(self.sent_number, now_s))
        self._guard.command(message.data, self.sent_s, now_s)

    def _take_temperature(self, message: Temperature) -> None:
        if self._interlock is None:
            return
        now_s = self.now_s()
        self._arming.latch(self._sources[TEMPERATURE.topic].heard(self.sent_number, now_s))
        stamp_s = from_stamp(message.header.stamp)
        self._arming.latch(self._interlock.read(to_kelvin(message.temperature), stamp_s, now_s))

    def _follow_parameters(self) -> None:
        self._guard.limits = power_limits(self, self._output.max_power_w)
        if self._interlock is not None:
            self._interlock.limits = temperature_limits(self)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    with ExitStack() as claims:

        def only() -> Laser:
            laser = Laser()
            claims.enter_context(only_laser(laser.context.get_domain_id(), laser.get_fully_qualified_name()))
            return laser

        return run(only, args)


if __name__ == "__main__":
    sys.exit(main())
