# SPDX-License-Identifier: Apache-2.0
"""A simulator of your own, with rclpy alone: a strip that warms as RC circuits do, and contracts around 60 °C.

    ros2 launch lce_bringup bench.launch.py simulator:=false
    python examples/own_simulator_node.py --ros-args -r __ns:=/lce

It takes the place of the node `simulator`: laser/power in, sim/temperature and sim/displacement out, 100 times a
second. The sensor nodes add noise, and show the rest of the bench what they measure (docs/how-to/ros2.md).
"""

import math
from contextlib import suppress
from typing import Final

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

PERIOD_S: Final = 0.01
POWER_TIMEOUT_S: Final = 0.1
"""A power older than this counts as zero: after `kill -9` of the laser node nobody else makes the strip dark."""
ROOM_C, GAIN_K_W, TIME_CONSTANT_S = 23.0, 70.0, 5.0
STROKE_M, MIDDLE_C, WIDTH_K = 3e-3, 60.0, 5.0


class Strip(Node):
    """tau dT/dt = T_room - T + gain P; d = stroke / (1 + exp(-(T - T_middle) / width))."""

    def __init__(self) -> None:
        super().__init__("own_simulator")
        self._power_w, self._sent_s, self._celsius = 0.0, -math.inf, ROOM_C
        self._last_s = self._now_s()
        self._temperature = self.create_publisher(Temperature, "sim/temperature", 10)
        self._displacement = self.create_publisher(Float64, "sim/displacement", 10)
        self._power = self.create_subscription(Float64, "laser/power", self._take_power, 10)
        self.create_timer(PERIOD_S, self._step)

    def _now_s(self) -> float:
        return self.get_clock().now().nanoseconds * 1e-9

    def _take_power(self, message: Float64, info: dict[str, int]) -> None:
        # As old as its publisher says: after a stall, the last words of a dead laser wait in the queue.
        self._sent_s = info["source_timestamp"] * 1e-9
        self._power_w = message.data if math.isfinite(message.data) else 0.0

    def _step(self) -> None:
        now_s = self._now_s()
        dt_s, self._last_s = max(now_s - self._last_s, 0.0), now_s
        if not self._power.get_publisher_count():
            return  # the first sample says that the whole chain is there
        power_w = self._power_w if now_s - self._sent_s <= POWER_TIMEOUT_S else 0.0
        steady_c = ROOM_C + GAIN_K_W * power_w
        self._celsius = steady_c + (self._celsius - steady_c) * math.exp(-dt_s / TIME_CONSTANT_S)
        temperature = Temperature(temperature=self._celsius)
        temperature.header.stamp = self.get_clock().now().to_msg()
        self._temperature.publish(temperature)
        contraction_m = STROKE_M / (1.0 + math.exp(-(self._celsius - MIDDLE_C) / WIDTH_K))
        self._displacement.publish(Float64(data=contraction_m))


def main() -> None:
    """Run the node until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(Strip())


if __name__ == "__main__":
    main()
