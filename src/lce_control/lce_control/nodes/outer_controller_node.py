# SPDX-License-Identifier: Apache-2.0
"""Node `outer_controller`: the temperature at which the strip is where it should be, the outer loop of Fig. 6.2.

Subscribes  target_displacement   std_msgs/Float64, m, latched
            displacement          std_msgs/Float64, m
            temperature           sensor_msgs/Temperature, °C: the integral rests far from the setpoint
            laser/armed           std_msgs/Bool, latched
Publishes   temperature_setpoint  sensor_msgs/Temperature, °C, 100 Hz; NaN: no setpoint
Calls       inverse_temperature   lce_interfaces/srv/InverseTemperature: the feed-forward, once for each target
Parameters  kp, ki, kd            K/m, K/(m s), K s/m: (6.12) unless set, its gains taken as per millimetre
            n, setpoint_weight, derivative_weight, filter_gain, filter_s, horizon_s   see PID and LowPass
            follow_k              K, the integral rests while the strip is further than this from the setpoint
            lower_c, upper_c      °C, limits of the setpoint
            displacement_timeout_s s, a displacement older than this is ignored
            displacement_fault_s  s, a silence of the displacement that is a fault
            frozen_after_s        s, a displacement that repeats itself bit for bit for so long is a fault; 0: never

All parameters are live, but the times can only be lowered, and frozen_after_s is read-only. The node publishes a
setpoint at once after each displacement, and at 100 Hz without any. It refuses a target out of reach, with the
reachable range in the log and in /diagnostics, and keeps the one before. The setpoint is NaN before the first target
and without a fresh displacement. A displacement that is silent or frozen while a target is followed is a fault: NaN
until the laser is disarmed.
"""

import math
import sys
from typing import Any, Final

from sensor_msgs.msg import Temperature

from lce_control.cascade import FOLLOW_K, OuterLoop
from lce_control.filters import Sample
from lce_control.nodes.controller_node import ControllerNode
from lce_control.nodes.displacement_node import DisplacementInput
from lce_control.nodes.loop_parameters import declare_loop, gains_text
from lce_control.nodes.target_node import TargetTracker
from lce_control.pid import Gains, Limits
from lce_data.channels import TEMPERATURE
from lce_data.topics import SETPOINT
from lce_ros.conversions import to_celsius, to_kelvin
from lce_ros.health import Level
from lce_ros.messages import to_message
from lce_ros.node import run

TUNED: Final = Gains(kp=39.0, ki=13.0, kd=2.0)
"""(6.12)"""


class OuterController(ControllerNode):
    """One loop from displacement [m] to temperature setpoint [K], beside the feed-forward."""

    reports_on = "setpoint"

    def __init__(self, **options: Any) -> None:
        super().__init__("outer_controller", **options)
        self.declare("lower_c", 0.0, "lowest setpoint", unit="°C", lower=-50.0, upper=50.0)
        self.declare("upper_c", 110.0, "highest setpoint", unit="°C", lower=50.0, upper=250.0)
        self.declare("follow_k", FOLLOW_K, "distance to the setpoint at which the integral rests", unit="K",
                     lower=0.0, upper=1000.0)  # fmt: skip
        loop = declare_loop(self, TUNED, self._limits, "K", "m")
        self._outer = OuterLoop(loop)
        self._target = TargetTracker(self)
        self._temperature_k = math.nan
        self._setpoint = self.advertise(Temperature, SETPOINT)
        self.listen(Temperature, TEMPERATURE.topic, self._take_temperature)
        self._displacement = DisplacementInput(self)
        setpoints = f"setpoints from {self.value('lower_c'):g} to {self.value('upper_c'):g} °C"
        self.introduce(f"{setpoints}; {gains_text(loop, 'K', 'm')}")

    def step(self, now_s: float) -> None:
        """Publish the setpoint for now."""
        self._target.update(now_s)
        displacement, setpoint_k = self._displacement.at(now_s, self._target.exists), math.nan
        if displacement is None or not self.laser_armed:
            self._outer.reset()
        if displacement is None:
            level = Level.ERROR if self._target.exists else Level.OK
            self.report(level, f"{self._displacement.missing}: no setpoint")
        elif not self._target.exists:
            level, why = self._target.missing
            self.report(level, f"{why}: no setpoint")
        else:
            setpoint_k = self._follow(now_s, displacement)
        if displacement is not None and (complaint := self._target.complaint) is not None:
            self.report(*complaint)
        self._setpoint.publish(to_message(TEMPERATURE, setpoint_k, now_s))

    def _follow(self, now_s: float, displacement: Sample) -> float:
        target_m, feedforward_k = self._target.target_m, self._target.temperature_k
        self._outer.follow_k = self.value("follow_k")
        setpoint_k = self._outer.step(now_s, target_m, feedforward_k, displacement, self._temperature_k)
        self.report(
            Level.OK,
            "controlling",
            target_mm=target_m * 1e3,
            displacement_mm=displacement.value * 1e3,
            feedforward_c=to_celsius(feedforward_k),
            setpoint_c=to_celsius(setpoint_k),
        )
        return setpoint_k

    def _limits(self) -> Limits:
        return Limits(to_kelvin(self.value("lower_c")), to_kelvin(self.value("upper_c")))

    def _take_temperature(self, message: Temperature) -> None:
        self._temperature_k = to_kelvin(message.temperature)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(OuterController, args)


if __name__ == "__main__":
    sys.exit(main())
