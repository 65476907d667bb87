# SPDX-License-Identifier: Apache-2.0
"""Node `thermal_camera`: temperature of the strip.

Publishes   temperature      sensor_msgs/Temperature, °C, 10 Hz; header.stamp is the time of acquisition
Subscribes  sim/temperature  sensor_msgs/Temperature, °C, the true one (device simulated only)
Parameters  device           simulated | flir
            noise_rms, quantum (K), latency_s (s), seed of the simulated camera
            flir.*           camera, ir_format, byte_order, x, y, width, height, statistic, lower_c, upper_c,
                             latency_s, packet_size
            stale_after_s    s, silence that is reported
"""

import sys
from typing import Any, Final

from sensor_msgs.msg import Temperature

from lce_drivers.background import Background
from lce_drivers.camera.flir import CameraSettings, FlirLink
from lce_drivers.camera.radiometry import BYTE_ORDERS, KELVIN_PER_COUNT, STATISTICS, Region
from lce_drivers.sensor import Imperfection, Reading, SensorDevice
from lce_drivers.sensor_node import DeviceFactory, SensorNode, Simulated
from lce_ros.conversions import from_stamp, to_celsius, to_kelvin, to_stamp
from lce_ros.node import run

RATE_HZ: Final = 10.0
POLL_S: Final = 0.01
SIMULATED: Final = Imperfection(noise_rms=0.06, quantum=0.01, latency_s=0.03)


def simulated(node: SensorNode) -> Simulated:
    """The camera as it looks at the simulated strip."""

    def read(message: Temperature) -> tuple[float, float]:
        return to_kelvin(message.temperature), from_stamp(message.header.stamp)

    return Simulated(node, (Temperature, "sim/temperature", read), "K", SIMULATED, RATE_HZ)


def flir(node: SensorNode) -> SensorDevice:
    """A FLIR A3x5 on the network, by Aravis."""

    def fixed(name: str, default: Any, description: str, **limits: Any) -> Any:
        return node.declare(f"flir.{name}", default, description, read_only=True, **limits)

    def pixels(name: str, description: str) -> int:
        return int(fixed(name, 0, description, unit="pixel", lower=0, upper=4096))

    settings = CameraSettings(
        camera=fixed("camera", "", "name or address, empty: the first found"),
        ir_format=fixed("ir_format", "TemperatureLinear10mK", "radiometry", choices=("", *KELVIN_PER_COUNT)),
        byte_order=fixed("byte_order", "little", "of Mono16 counts", choices=BYTE_ORDERS),
        region=Region(
            pixels("x", "left edge of the strip"),
            pixels("y", "upper edge of the strip"),
            pixels("width", "width of the strip, 0: to the edge"),
            pixels("height", "height of the strip, 0: to the edge"),
        ),
        statistic=fixed("statistic", "mean", "one temperature from the region", choices=STATISTICS),
        lower_k=to_kelvin(fixed("lower_c", -20.0, "coldest that is believed", unit="°C", lower=-273.15, upper=2000.0)),
        upper_k=to_kelvin(fixed("upper_c", 350.0, "hottest that is believed", unit="°C", lower=-273.15, upper=2000.0)),
        latency_s=fixed("latency_s", 0.03, "age of a frame when it is here", unit="s", lower=0.0, upper=1.0),
        packet_size=fixed("packet_size", 0, "0: the camera's own", unit="byte", lower=0, upper=9000),
        rate_hz=RATE_HZ,
    )
    device = Background(lambda: FlirLink(settings, node.now_s), "flir")
    node.every(POLL_S, lambda: node.deliver_newest(device.poll()))
    return device


DEVICES: Final[dict[str, DeviceFactory]] = {"simulated": simulated, "flir": flir}


class ThermalCamera(SensorNode):
    """Publishes temperatures [K] of its device in °C."""

    def __init__(self, **options: Any) -> None:
        super().__init__("thermal_camera", DEVICES, **options)
        self._temperature = self.advertise(Temperature, "temperature")

    def publish(self, reading: Reading) -> None:
        """Put a reading into its message."""
        message = Temperature(temperature=to_celsius(reading.value), variance=reading.variance)
        message.header.stamp = to_stamp(reading.t_s)
        message.header.frame_id = "strip"
        self._temperature.publish(message)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(ThermalCamera, args)


if __name__ == "__main__":
    sys.exit(main())
