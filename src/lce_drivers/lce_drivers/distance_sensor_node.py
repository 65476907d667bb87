# SPDX-License-Identifier: Apache-2.0
"""Node `distance_sensor`: displacement of the strip's free end.

Publishes   displacement      std_msgs/Float64, m, contraction positive, 100 Hz
Subscribes  sim/displacement  std_msgs/Float64, m, the true one (device simulated only)
Parameters  device            simulated | keyence; the latter declares the parameters of `keyence_sensor`
            noise_rms, quantum (m), latency_s (s), seed of the simulated sensor
            stale_after_s     s, silence that is reported

The simulated sensor measures each sample of the strip, and as it comes: a timer of its own would make every
recorded displacement one tick late.
"""

import math
import sys
from typing import Any, Final

from lce_ros.node import run
from std_msgs.msg import Float64

from lce_drivers.sensor import Imperfection, Reading
from lce_drivers.sensor_node import DeviceFactory, SensorNode, Simulated

SIMULATED: Final = Imperfection(noise_rms=4e-6, quantum=1e-6, latency_s=0.0)


def simulated(node: SensorNode) -> Simulated:
    """The sensor as it looks at the simulated strip."""

    def read(message: Float64) -> tuple[float, float]:
        return message.data, node.now_s()

    return Simulated(node, (Float64, "sim/displacement", read), "m", SIMULATED, math.inf)


DEVICES: Final[dict[str, DeviceFactory]] = {"simulated": simulated}


class DistanceSensor(SensorNode):
    def __init__(self, **options: Any) -> None:
        super().__init__("distance_sensor", DEVICES, **options)
        self._displacement = self.advertise(Float64, "displacement")

    def publish(self, reading: Reading) -> None:
        self._displacement.publish(Float64(data=reading.value))


def main(args: list[str] | None = None) -> int:
    return run(DistanceSensor, args)


if __name__ == "__main__":
    sys.exit(main())
