# SPDX-License-Identifier: Apache-2.0
"""Node `laser`: the last word on laser power.

Subscribes  laser/power_command  std_msgs/Float64, W
            temperature          sensor_msgs/Temperature, °C; header.stamp is the time of measurement
Publishes   laser/power          std_msgs/Float64, W as applied, 100 Hz
            laser/power_stamped  lce_interfaces/Float64Stamped, the same; header.stamp is when it was applied
            laser/power_command_stamped  lce_interfaces/Float64Stamped, each command heard; header.stamp is when it
                                 was published
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
            arm_at_start         armed when the node is activated; a device that makes light refuses it
            device               simulated | labjack
            autostart            configure and activate when the node starts
            labjack.*            host, port, volts_per_watt, threshold_v, max_v, timeout_s, watchdog_s

A managed node (lce_ros.managed_node): configuring it opens the device and checks it. While it is inactive the device is
held at zero, and looked after, and nothing is published but laser/armed, false. An error of a transition is a fault.

All parameters are read-only; max_power_w and max_temperature_c can be lowered.

The power is zero unless the node is armed, without a fresh, finite command, without a fresh temperature, from a fault
until laser/reset and laser/arm, and on every way out of the process. Faults are those of the parameters, a second
publisher of commands or temperatures, and a device that is not as it was left. After `kill -9` the node can do nothing
more. Then the receiver of the power sets it to zero: the simulator if laser/power is older than 100 ms, the hardware by
its watchdog. A device that does not answer ends the node with status 1. The states: docs/explanation/safety.md.
"""

import math
import sys
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Final

from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.parameter import Parameter
from sensor_msgs.msg import Temperature
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger

from lce_data.channels import POWER, TEMPERATURE, stamped_topic
from lce_data.topics import ARMED, COMMAND, COMMAND_STAMPED
from lce_drivers.laser.arming import Arming
from lce_drivers.laser.clock_watch import QUIET_CHECKS, ClockWatch, StallWatch
from lce_drivers.laser.condition import condition, dark
from lce_drivers.laser.devices import DEVICES
from lce_drivers.laser.interlock import Interlock
from lce_drivers.laser.laser_limits import declare_limits, no_temperature_left, power_limits, temperature_limits
from lce_drivers.laser.power_guard import PowerGuard, PowerOutput
from lce_drivers.laser.sole_source import SoleSource
from lce_interfaces.msg import Float64Stamped
from lce_ros.conversions import from_stamp, to_kelvin
from lce_ros.domain import only_laser
from lce_ros.health import Level
from lce_ros.managed_node import ManagedNode
from lce_ros.messages import stamped_number
from lce_ros.node import NodeFault, run

PERIOD_S: Final = 0.01
LAST_WORD_S: Final = 0.2
CLOCK_CHECK_S: Final = 0.1
DEVICE_CHECK_S: Final = 1.0


class Laser(ManagedNode):
    """Applies the power that the guard and the interlock allow while it is active and armed, 100 times a second."""

    reports_on = "output"

    def __init__(self, claim: Callable[["Laser"], object] = lambda _: None, **options: Any) -> None:
        """``claim`` is called before the device is opened; it raises if another process has the laser."""
        super().__init__("laser", **options)
        declare_limits(self)
        device = self.declare("device", "simulated", "what drives the laser", choices=tuple(DEVICES), read_only=True)
        required = self.declare("temperature_required", True, "false: the bench has no thermal camera", read_only=True)
        self._device = DEVICES[device](self)
        self.hardware_id = self._device.what
        self._arms_itself = self._armed_at_start()
        self._output: PowerOutput | None = None
        self._guard = PowerGuard(power_limits(self, math.inf))
        self._interlock = Interlock(temperature_limits(self)) if required else None
        self._sources = {topic: SoleSource(topic) for topic in (COMMAND, TEMPERATURE.topic)}
        self._arming = Arming()
        self._announced: tuple[bool, str | None] | None = None
        self._announced_s = 0.0
        self._power_w = 0.0
        self._crowd: str | None = None
        self.add_on_set_parameters_callback(self._refusal)
        self.add_post_set_parameters_callback(lambda _: self._follow_parameters())
        self._power = self.advertise(Float64, POWER.topic)
        self._power_stamped = self.advertise(Float64Stamped, stamped_topic(POWER.topic))
        self._command_stamped = self.advertise(Float64Stamped, COMMAND_STAMPED)
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
        claim(self)
        self.start()

    def open_device(self) -> None:
        """Open the device, which is at zero power then."""
        self._output = self._device.open()
        self._follow_parameters()

    def begin(self) -> None:
        """Follow commands from now on; a laser that arms itself is armed unless there is a fault."""
        self._guard.forget(self.now_s())
        if self._arms_itself:
            self._arming.arm(0.0, math.inf if self._announced is None else self._announced_for_s(self.now_s()))
        limits = [f"{self._guard.limits.max_power_w:g} W"]
        if self._interlock is not None:
            limits.append(f"{self.value('max_temperature_c'):g} °C")
        self.get_logger().info(f"{self.hardware_id}: {1.0 / PERIOD_S:g} Hz, at most {' and '.join(limits)}")

    def rest(self) -> None:
        """Zero power, disarmed."""
        self._arming.disarm()
        self._write(self._guard.cut(self.now_s()))
        self._publish_power(0.0)
        self._announce_arming()

    def close_device(self) -> None:
        """Zero power: at the device first, then as the last word on laser/power."""
        if self._output is None:
            return
        output, self._output, self._power_w = self._output, None, 0.0
        try:
            output.close()
        except OSError as error:
            # Only the device's watchdog can end the light now; to publish zero would be a guess.
            self.get_logger().error(f"zero power could not be set: {error}")
            return
        if self.context.ok():
            self._publish_power(0.0)
            for publisher in (self._power, self._power_stamped):
                publisher.wait_for_all_acked(Duration(seconds=LAST_WORD_S))

    def failed(self, reason: str) -> None:
        """A fault, until laser/reset."""
        self._arming.latch(reason)
        self._announce_arming()

    def _armed_at_start(self) -> bool:
        real = self._device.makes_light
        armed: bool = self.declare("arm_at_start", not real, "armed when the node is activated", read_only=True)
        if armed and real:
            raise ValueError("laser: arm_at_start: a laser that makes light is armed by laser/arm alone")
        return armed

    def _tick(self) -> None:
        if not self.active:
            self._keep_dark()
            return
        now_s = self.now_s()
        if not self.on_sim_time:
            self._check_stall(now_s)
        wanted_w = self._guard.power_w(self.tick_s, now_s)
        self._judge(now_s, wanted_w)
        cold = self._interlock is not None and wanted_w > 0.0 and not self._interlock.is_fresh(now_s)
        self._write(self._guard.cut(now_s) if cold or not self._arming.armed else wanted_w)
        self._publish_power(self._power_w)
        self._announce_arming()
        self._report_beside_crowd(
            *condition(self._arming, self._guard.state, wanted_w, cold),
            power_w=self._power_w,
            invalid_commands=self._guard.invalid_commands,
        )

    def _keep_dark(self) -> None:
        """A tick of an inactive laser: write zero to its device, and so see that the device still answers."""
        if self._output is not None:
            self._write(0.0)
            self._announce_arming()
            self._report_beside_crowd(*dark(self._arming), power_w=0.0)

    def _report_beside_crowd(self, level: Level, words: str, **values: Any) -> None:
        """Report a condition; one that is no error also names the topics that have several publishers."""
        if self._crowd is not None and level is not Level.ERROR:
            level, words = Level.WARN, f"{words}; {self._crowd}"
        self.report(level, words, **values)

    def _write(self, power_w: float) -> None:
        assert self._output is not None
        self._power_w = power_w
        try:
            self._output.write(power_w)
        except OSError as error:
            raise NodeFault(f"laser: {error}") from error

    def _publish_power(self, power_w: float) -> None:
        """Publish the power [W] that is applied from now on: with its time first, for whoever stops at a last zero."""
        self._power_stamped.publish(stamped_number(power_w, self.now_s()))
        self._power.publish(Float64(data=power_w))

    def _judge(self, now_s: float, wanted_w: float) -> None:
        """Latch what is wrong with command and temperature."""
        armed = self._arming.armed
        if armed:
            self._arming.latch(self._guard.fault(now_s))
            if self._device.makes_light and self._guard.abandoned(now_s):
                self._arming.disarm()
                self.get_logger().warning("nobody commands: whoever does next has to be let in by laser/arm")
        if self._interlock is not None:
            wanted = None if not self._guard.heard(now_s) else wanted_w if armed else 0.0
            self._arming.latch(self._interlock.judge(now_s, wanted))

    def _check_stall(self, now_s: float) -> None:
        stall = self._stall_watch.tick(self._steady.now().nanoseconds * 1e-9, now_s, self._power_w > 0.0)
        if stall is not None:
            self._arming.latch(stall)
            self._arming.latch(self._mismatch())

    def _mismatch(self) -> str | None:
        if self._output is None:
            return "the laser is not configured"
        try:
            return self._output.mismatch()
        except OSError as error:
            raise NodeFault(f"laser: {error}") from error

    def _announce_arming(self) -> None:
        """Publish and log a change of the state."""
        arming = self._arming
        before, self._announced = self._announced, (arming.armed, arming.fault)
        if before == self._announced:
            return
        if before is None or before[0] != arming.armed:
            self._armed.publish(Bool(data=arming.armed))
            self._announced_s = self.now_s()
        if arming.armed and before is not None:
            self.get_logger().warning("armed")
        elif not arming.armed:
            self.tell(*dark(arming))

    def _arm(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        if not request.data:
            self._arming.disarm()
            response.success, response.message = True, "disarmed"
            return response
        now_s, before = self.now_s(), self._arming.armed
        refusal: str | None = "the laser is not active"
        if self.active:
            refusal = self._arming.arm(self._guard.commanded_w(now_s), self._announced_for_s(now_s))
        if self._arming.armed and not before:
            # What was commanded until now belongs to the time before.
            self._guard.forget(now_s)
        response.success, response.message = refusal is None, "armed" if refusal is None else f"not armed: {refusal}"
        return response

    def _announced_for_s(self, now_s: float) -> float:
        """How long [s] everybody could know that the laser is not armed."""
        return now_s - self._announced_s if self._announced is not None and not self._announced[0] else 0.0

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
        if self._output is not None:
            self._arming.latch(self._mismatch())
        crowds = [f"{count} nodes could publish {topic}" for topic in self._sources
                  if (count := self.count_publishers(topic)) > 1]  # fmt: skip
        self._crowd = "; ".join(crowds) or None

    def _check_clock(self) -> None:
        if self._clock_watch.stopped(self.ticks):
            raise NodeFault(f"laser: no tick for {QUIET_CHECKS * CLOCK_CHECK_S:g} s: the system clock was set back")

    def _take_command(self, message: Float64) -> None:
        if not self.active:
            return
        now_s = self.now_s()
        self._arming.latch(self._sources[COMMAND].heard(self.sent_number, now_s))
        nonsense = self._guard.command(message.data, self.sent_s, now_s)
        if self._arming.armed:
            self._arming.latch(nonsense)
        self._command_stamped.publish(stamped_number(message.data, self.sent_s))

    def _take_temperature(self, message: Temperature) -> None:
        if self._interlock is None:
            return
        now_s = self.now_s()
        self._arming.latch(self._sources[TEMPERATURE.topic].heard(self.sent_number, now_s))
        stamp_s = from_stamp(message.header.stamp)
        self._arming.latch(self._interlock.read(to_kelvin(message.temperature), stamp_s, now_s))

    def _refusal(self, parameters: list[Parameter]) -> SetParametersResult:
        """Refuse a highest temperature that leaves none that is allowed."""
        lowest_c = self.value("min_temperature_c")
        for parameter in parameters:
            highest_c = parameter.value if parameter.name == "max_temperature_c" else math.inf
            # A text is refused by its type.
            wrong = no_temperature_left(lowest_c, highest_c) if isinstance(highest_c, float) else None
            if wrong is not None:
                return SetParametersResult(successful=False, reason=wrong)
        return SetParametersResult(successful=True)

    def _follow_parameters(self) -> None:
        device_w = math.inf if self._output is None else self._output.max_power_w
        self._guard.limits = power_limits(self, device_w)
        if self._interlock is not None:
            self._interlock.limits = temperature_limits(self)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    with ExitStack() as claims:

        def claim(laser: Laser) -> None:
            claims.enter_context(only_laser(laser.context.get_domain_id(), laser.get_fully_qualified_name()))

        return run(lambda: Laser(claim), args)


if __name__ == "__main__":
    sys.exit(main())
