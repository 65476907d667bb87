# SPDX-License-Identifier: Apache-2.0
"""Node `single_controller`: laser power straight from the displacement, the single loop of §6.5.3, for comparison.

Subscribes  target_displacement   std_msgs/Float64, m, latched
            displacement          std_msgs/Float64, m
            laser/armed           std_msgs/Bool, latched
Publishes   laser/power_command   std_msgs/Float64, W, 100 Hz
Calls       inverse_temperature   lce_interfaces/srv/InverseTemperature: checks that a target can be reached
Parameters  kp, ki, kd            W/m, W/(m s), W s/m: those of §6.5.3 unless set, taken as per millimetre
            n, setpoint_weight, derivative_weight, filter_gain, filter_s, horizon_s   see PID and LowPass
            max_power_w           W, limit of the command
            displacement_timeout_s s, a displacement older than this is ignored
            displacement_fault_s  s, a silence of the displacement that is a fault
            frozen_after_s        s, a displacement that repeats itself bit for bit for so long is a fault; 0: never

All parameters are live, but the times can only be lowered, and frozen_after_s is read-only. The node publishes a
command at once after each displacement, and at 100 Hz without any. It refuses a target out of reach as
`outer_controller` does. The command is zero without a target or a fresh displacement, while the laser is not armed, and
when the node ends. A displacement that is silent or frozen while a target is followed is a fault: zero until the laser
is disarmed.
"""

import sys
from typing import Any, Final

from lce_control.nodes.controller_node import PowerControllerNode
from lce_control.nodes.displacement_node import DisplacementInput
from lce_control.nodes.loop_parameters import declare_loop, gains_text
from lce_control.nodes.target_node import TargetTracker
from lce_control.pid import Gains, Limits
from lce_ros.health import Level
from lce_ros.node import run

TUNED: Final = Gains(kp=5837.0, ki=192.0, kd=11.0)
"""§6.5.3"""


class SingleController(PowerControllerNode):
    """One loop from displacement [m] to power [W]."""

    reports_on = "power"

    def __init__(self, **options: Any) -> None:
        super().__init__("single_controller", **options)
        self.declare("max_power_w", 2.0, "limit of the command", unit="W", lower=0.0, upper=10.0)
        self._loop = declare_loop(self, TUNED, lambda: Limits(0.0, self.value("max_power_w")), "W", "m")
        self._target = TargetTracker(self)
        self._displacement = DisplacementInput(self)
        self.introduce(f"at most {self.value('max_power_w'):g} W; {gains_text(self._loop, 'W', 'm')}")

    def step(self, now_s: float) -> None:
        """Command the power for now."""
        self._target.update(now_s)
        displacement, power_w = self._displacement.at(now_s, self._target.exists), 0.0
        if not self.laser_armed:
            self._loop.reset()
            self.report(Level.OK, "the laser is not armed: zero power")
        elif displacement is None:
            self._loop.reset()
            level = Level.ERROR if self._target.exists else Level.OK
            self.report(level, f"{self._displacement.missing}: zero power")
        elif not self._target.exists:
            level, why = self._target.missing
            self.report(level, f"{why}: zero power")
        else:
            power_w = self._loop.step(now_s, self._target.target_m, displacement)
            self.report(
                Level.OK,
                "controlling",
                target_mm=self._target.target_m * 1e3,
                displacement_mm=displacement.value * 1e3,
                power_w=power_w,
            )
        if displacement is not None and (complaint := self._target.complaint) is not None:
            self.report(*complaint)
        self.command(power_w)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(SingleController, args)


if __name__ == "__main__":
    sys.exit(main())
