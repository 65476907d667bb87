# SPDX-License-Identifier: Apache-2.0
"""Node `thermal_camera`: temperature of the strip.

Publishes   temperature      sensor_msgs/Temperature, °C, 10 Hz; header.stamp is the time of acquisition
Subscribes  sim/temperature  sensor_msgs/Temperature, °C, the true one (device simulated only)
Parameters  device           simulated | flir; the latter declares the parameters of `flir_camera`
            noise_rms, quantum (K), latency_s (s), seed of the simulated camera
            stale_after_s    s, silence that is reported
"""

import sys
from typing import Any, Final

from lce_ros.conversions import from_stamp, to_celsius, to_kelvin, to_stamp
from lce_ros.node import run
from sensor_msgs.msg import Temperature

from lce_drivers.sensor import Imperfection, Reading
from lce_drivers.sensor_node import DeviceFactory, SensorNode, Simulated

RATE_HZ: Final = 10.0
SIMULATED: Final = Imperfection(noise_rms=0.06, quantum=0.01, latency_s=0.03)


def simulated(node: SensorNode) -> Simulated:
    """The camera as it looks at the simulated strip."""

    def read(message: Temperature) -> tuple[float, float]:
        return to_kelvin(message.temperature), from_stamp(message.header.stamp)

    return Simulated(node, (Temperature, "sim/temperature", read), "K", SIMULATED, RATE_HZ)


DEVICES: Final[dict[str, DeviceFactory]] = {"simulated": simulated}


class ThermalCamera(SensorNode):
    def __init__(self, **options: Any) -> None:
        super().__init__("thermal_camera", DEVICES, **options)
        self._temperature = self.advertise(Temperature, "temperature")

    def publish(self, reading: Reading) -> None:
        message = Temperature(temperature=to_celsius(reading.value), variance=reading.variance)
        message.header.stamp = to_stamp(reading.t_s)
        message.header.frame_id = "strip"
        self._temperature.publish(message)


def main(args: list[str] | None = None) -> int:
    return run(ThermalCamera, args)


if __name__ == "__main__":
    sys.exit(main())
