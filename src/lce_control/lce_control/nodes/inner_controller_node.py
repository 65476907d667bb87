# SPDX-License-Identifier: Apache-2.0
"""Node `inner_controller`: laser power that brings the strip to a temperature, the inner loop of Fig. 6.2 of Wu (2021).

Subscribes  temperature_setpoint  sensor_msgs/Temperature, °C; NaN: no setpoint
            temperature           sensor_msgs/Temperature, °C; header.stamp is the time of measurement
            laser/armed           std_msgs/Bool, latched
Publishes   laser/power_command   std_msgs/Float64, W, 100 Hz
Parameters  kp, ki, kd            W/K, W/(K s), W s/K: (6.11) unless set
            n, setpoint_weight, derivative_weight, filter_gain, filter_s, horizon_s   see PID and LowPass
            max_power_w           W, limit of the command
            setpoint_timeout_s    s, a setpoint older than this is ignored
            setpoint_fault_s      s, without a setpoint, or with NaN, after one was followed: a fault
            temperature_timeout_s s, a temperature older than this is ignored

All parameters are live; the times can only be lowered. The node publishes a command at once after each setpoint, and at
100 Hz without any. The command is zero without a fresh setpoint or temperature, and while the laser is not armed;
afterwards control starts anew. After a fault it stays zero until the laser is disarmed and armed. When the node ends,
its last command is zero.
"""

import math
import sys
from typing import Any, Final

from sensor_msgs.msg import Temperature

from lce_control.filters import Sample
from lce_control.nodes.controller_node import PowerControllerNode
from lce_control.nodes.loop_parameters import declare_loop, gains_text
from lce_control.pid import Gains, Limits
from lce_data.channels import TEMPERATURE
from lce_data.topics import SETPOINT
from lce_ros.conversions import from_stamp, to_celsius, to_kelvin
from lce_ros.health import FAULT, Level
from lce_ros.node import run

TUNED: Final = Gains(kp=0.05, ki=0.01, kd=0.001)
"""(6.11)"""


class InnerController(PowerControllerNode):
    """One loop from temperature [K] to power [W]."""

    reports_on = "power"

    def __init__(self, **options: Any) -> None:
        super().__init__("inner_controller", **options)
        self.declare("max_power_w", 2.0, "limit of the command", unit="W", lower=0.0, upper=10.0)
        self.declare_time("setpoint_timeout_s", 0.1, "a setpoint older than this is ignored", 0.02, 1.0)
        self.declare_time("setpoint_fault_s", 0.5, "a silence of the setpoint that is a fault", 0.1, 10.0)
        self.declare_temperature_timeout()
        self._loop = declare_loop(self, TUNED, lambda: Limits(0.0, self.value("max_power_w")), "W", "K")
        self._setpoint: Sample | None = None
        self._finite: Sample | None = None
        self._follows, self._fault = False, ""
        self._temperature: Sample | None = None
        self.listen(Temperature, TEMPERATURE.topic, self._take_temperature)
        self.driven_by(Temperature, SETPOINT, self._take_setpoint)
        self.introduce(f"at most {self.value('max_power_w'):g} W; {gains_text(self._loop, 'W', 'K')}")

    def step(self, now_s: float) -> None:
        """Command the power for now."""
        setpoint, temperature = self._setpoint, self._temperature
        power_w = 0.0
        self._judge(now_s)
        if not self.laser_armed:
            self._rest(Level.OK, "the laser is not armed")
        elif self._fault:
            self._rest(Level.ERROR, f"{FAULT}{self._fault}")
        elif setpoint is None or not math.isfinite(setpoint.value):
            self._rest(Level.OK, "no setpoint")
        elif not self.is_fresh(setpoint, now_s, "setpoint_timeout_s"):
            self._rest(Level.WARN, "the setpoint is stale")
        elif not self.is_fresh(temperature, now_s, "temperature_timeout_s"):
            self._rest(Level.ERROR, "no fresh temperature")
        else:
            self._follows = True
            power_w = self._loop.step(now_s, setpoint.value, temperature)
            self.report(
                Level.OK,
                "controlling",
                setpoint_c=to_celsius(setpoint.value),
                temperature_c=to_celsius(temperature.value),
                power_w=power_w,
            )
        self.command(power_w)

    def _judge(self, now_s: float) -> None:
        """Latch the fault of an outer controller that fell silent, or gave up; disarming the laser clears it.

        Were it not latched here, another outer controller would bring back the light.
        """
        if not self.laser_armed:
            self._follows, self._fault = False, ""
        elif self._follows and not self._fault and not self.is_fresh(self._finite, now_s, "setpoint_fault_s"):
            self._fault = f"no setpoint for {self.value('setpoint_fault_s'):g} s"
            self.get_logger().error(f"{self._fault}. Disarm the laser and arm it to go on.")

    def _rest(self, level: Level, why: str) -> None:
        self._loop.reset()
        self.report(level, f"{why}: zero power", power_w=0.0)

    def _take_setpoint(self, message: Temperature) -> None:
        self._setpoint = Sample(to_kelvin(message.temperature), min(self.sent_s, self.now_s()))
        if math.isfinite(message.temperature):
            self._finite = self._setpoint

    def _take_temperature(self, message: Temperature) -> None:
        if math.isfinite(message.temperature):
            self._temperature = Sample(to_kelvin(message.temperature), from_stamp(message.header.stamp))


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(InnerController, args)


if __name__ == "__main__":
    sys.exit(main())
