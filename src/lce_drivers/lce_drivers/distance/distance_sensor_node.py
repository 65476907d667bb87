# SPDX-License-Identifier: Apache-2.0
"""Node `distance_sensor`: displacement of the strip's free end.

Publishes   displacement      std_msgs/Float64, m, contraction positive, 100 Hz
Subscribes  sim/displacement  std_msgs/Float64, m, the true one (device simulated only)
Parameters  device            simulated | keyence
            noise_rms, quantum (m), latency_s (s), seed of the simulated sensor
            keyence.*         port, baud_rate, timeout_s, dialect, out, sign, zero, metres
            stale_after_s     s, silence that is reported

The simulated sensor measures each sample of the strip, and as it comes: a timer of its own would make every
recorded displacement one tick late.
"""

import math
import sys
from typing import Any, Final

from std_msgs.msg import Float64

from lce_drivers.background import Background
from lce_drivers.distance.keyence import DIALECTS, KeyenceLink, Mounting, open_port
from lce_drivers.sensor import Imperfection, Reading, SensorDevice
from lce_drivers.sensor_node import DeviceFactory, SensorNode, Simulated
from lce_ros.node import run

PERIOD_S: Final = 0.01
SIMULATED: Final = Imperfection(noise_rms=4e-6, quantum=1e-6, latency_s=0.0)


def simulated(node: SensorNode) -> Simulated:
    """The sensor as it looks at the simulated strip."""

    def read(message: Float64) -> tuple[float, float]:
        return message.data, node.now_s()

    return Simulated(node, (Float64, "sim/displacement", read), "m", SIMULATED, math.inf)


def keyence(node: SensorNode) -> SensorDevice:
    """A Keyence LK-G5000 or LK-G controller on a serial port."""

    def fixed(name: str, default: Any, description: str, **limits: Any) -> Any:
        return node.declare(f"keyence.{name}", default, description, read_only=True, **limits)

    path = fixed("port", "/dev/ttyUSB0", "serial port")
    baud_rate = fixed("baud_rate", 115200, "baud rate", unit="1/s", lower=1200, upper=921600)
    timeout_s = fixed("timeout_s", 0.1, "longest wait for an answer", unit="s", lower=0.01, upper=1.0)
    dialect = fixed("dialect", "lk_g5000", "language of the controller", choices=tuple(DIALECTS))
    out = fixed("out", 1, "output of the controller", lower=1, upper=12)
    mounting = Mounting(
        sign=fixed("sign", 1.0, "-1 where contraction lowers the display", lower=-1.0, upper=1.0),
        zero=fixed("zero", 0.0, "sign * display of the strip at rest", unit="unit of the display"),
        metres=fixed("metres", 1e-3, "unit of the display", unit="m", lower=1e-9, upper=1.0),
    )
    device = Background(
        lambda: KeyenceLink(open_port(path, baud_rate, timeout_s), dialect, out, mounting, node.now_s),
        "keyence",
    )
    node.every(PERIOD_S, lambda: node.deliver_newest(device.poll()))
    return device


DEVICES: Final[dict[str, DeviceFactory]] = {"simulated": simulated, "keyence": keyence}


class DistanceSensor(SensorNode):
    """Publishes displacements [m] of its device."""

    def __init__(self, **options: Any) -> None:
        super().__init__("distance_sensor", DEVICES, **options)
        self._displacement = self.advertise(Float64, "displacement")

    def publish(self, reading: Reading) -> None:
        """Put a reading into its message."""
        self._displacement.publish(Float64(data=reading.value))


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(DistanceSensor, args)


if __name__ == "__main__":
    sys.exit(main())
