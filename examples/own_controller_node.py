# SPDX-License-Identifier: Apache-2.0
"""A controller of your own, with rclpy alone: power in proportion to what is missing of the displacement.

    ros2 launch lce_bringup bench.launch.py
    python examples/own_controller_node.py --ros-args -r __ns:=/lce -p target_m:=0.0015 -p gain_w_per_m:=800.0

It commands with each reading of the distance sensor. When the sensor falls silent, so does this node, and the laser
node, which has the last word on power, sets it to zero (docs/explanation/safety.md).
"""

import math
from contextlib import suppress

import rclpy
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from std_msgs.msg import Float64


class ProportionalController(Node):
    """Power = gain x (target - displacement), never below zero."""

    def __init__(self) -> None:
        super().__init__("own_controller")
        self.declare_parameter("target_m", 0.001, ParameterDescriptor(description="target of the displacement [m]"))
        self.declare_parameter("gain_w_per_m", 500.0, ParameterDescriptor(description="power per missing metre [W/m]"))
        self._command = self.create_publisher(Float64, "laser/power_command", 10)
        self.create_subscription(Float64, "displacement", self._step, 10)

    def _step(self, displacement: Float64) -> None:
        missing_m = self.get_parameter("target_m").value - displacement.data
        power_w = self.get_parameter("gain_w_per_m").value * missing_m
        self._command.publish(Float64(data=max(power_w, 0.0) if math.isfinite(power_w) else 0.0))


def main() -> None:
    """Run the node until Ctrl-C; the laser goes dark when its commands end."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(ProportionalController())


if __name__ == "__main__":
    main()
