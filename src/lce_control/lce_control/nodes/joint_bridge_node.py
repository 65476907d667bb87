# SPDX-License-Identifier: Apache-2.0
"""Node `joint_bridge`: the strip as a prismatic joint, for ros2_control's joint_state_topic_hardware_interface.

Subscribes  displacement_stamped  lce_interfaces/Float64Stamped, m
            joint_commands        sensor_msgs/JointState: position of the joint, m
Publishes   joint_states          sensor_msgs/JointState: position of the joint, m, with the time of measurement
            target_displacement   std_msgs/Float64, m, latched, on change
Parameters  joint                 the joint's name

A command moves the target that the controllers of the bench follow; it never moves the laser itself. The bridge ignores
a command without the joint or without a finite position. What it is for:
docs/explanation/decisions/0020-beside-ros2-control.md.
"""

import math
import sys
from typing import Any

from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from lce_data.channels import DISPLACEMENT, stamped_topic
from lce_data.topics import TARGET
from lce_interfaces.msg import Float64Stamped
from lce_ros.health import Level
from lce_ros.node import LceNode, run


class JointBridge(LceNode):
    """Displacements become states of a joint; its commands become targets."""

    reports_on = "joint"

    def __init__(self, **options: Any) -> None:
        super().__init__("joint_bridge", **options)
        self._joint = self.declare("joint", "strip", "name of the joint in the URDF", read_only=True)
        self._target_m = math.nan
        self._states = self.advertise(JointState, "joint_states")
        self._targets = self.advertise(Float64, TARGET, latched=True)
        self.listen(Float64Stamped, stamped_topic(DISPLACEMENT.topic), self._take_displacement)
        self.listen(JointState, "joint_commands", self._take_command)
        self.report(Level.OK, f"the strip is the joint {self._joint}")

    def _take_displacement(self, message: Float64Stamped) -> None:
        self._states.publish(JointState(header=message.header, name=[self._joint], position=[message.value]))

    def _take_command(self, message: JointState) -> None:
        commanded = dict(zip(message.name, message.position, strict=False))  # ros2_control leaves out what it lacks
        target_m = commanded.get(self._joint, math.nan)
        if math.isfinite(target_m) and target_m != self._target_m:
            self._target_m = target_m
            self._targets.publish(Float64(data=target_m))


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(JointBridge, args)


if __name__ == "__main__":
    sys.exit(main())
