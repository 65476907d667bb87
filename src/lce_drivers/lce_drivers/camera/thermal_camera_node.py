# SPDX-License-Identifier: Apache-2.0
"""Node `thermal_camera`: temperature of the strip.

Publishes   temperature      sensor_msgs/Temperature, °C, 10 Hz; header.stamp is the time of acquisition
Subscribes  sim/temperature  sensor_msgs/Temperature, °C, the true one (device simulated only)
Parameters  device           simulated | flir
            noise_rms, quantum (K), latency_s (s), seed of the simulated camera
            flir.*           camera, ir_format, byte_order, x, y, width, height, statistic, lower_c, upper_c,
                             latency_s, packet_size
            stale_after_s    s, silence after which the node warns in /diagnostics
            autostart        configure and activate when the node starts

A managed node (lce_ros.managed_node): configuring it opens the device and waits for a reading, activating it publishes.
"""

import sys
from typing import Any, Final

from lce_data.channels import TEMPERATURE
from lce_drivers.background import Background
from lce_drivers.camera.flir import CameraSettings, FlirLink
from lce_drivers.camera.radiometry import BYTE_ORDERS, KELVIN_PER_COUNT, STATISTICS, Region
from lce_drivers.sensor import DataSheet
from lce_drivers.sensor_node import DeviceFactory, SensorNode, SensorOpener
from lce_ros.conversions import to_kelvin
from lce_ros.node import run

SHEET: Final = DataSheet(rate_hz=10.0, noise_rms=TEMPERATURE.noise, quantum=0.01, latency_s=0.03)
POLL_S: Final = 0.01


def flir(node: SensorNode) -> SensorOpener:
    """A FLIR A3x5 on the network, by Aravis."""
    settings = _declared_settings(node)
    node.hardware_id = f"flir {settings.camera or '(first found)'}"
    node.every(POLL_S, node.poll)
    return lambda: Background(lambda: FlirLink(settings, node.now_s), "flir")


def _declared_settings(node: SensorNode) -> CameraSettings:
    """The parameters flir.* of the node."""

    def fixed(name: str, default: Any, description: str, **limits: Any) -> Any:
        return node.declare(f"flir.{name}", default, description, read_only=True, **limits)

    def pixels(name: str, description: str) -> int:
        return int(fixed(name, 0, description, unit="pixel", lower=0, upper=4096))

    def kelvin(name: str, default_c: float, description: str) -> float:
        return to_kelvin(fixed(name, default_c, description, unit="°C", lower=-273.15, upper=2000.0))

    settings = CameraSettings(
        camera=fixed("camera", "", "name or address, empty: the first found"),
        ir_format=fixed(
            "ir_format",
            "TemperatureLinear10mK",
            "scale of the counts, empty: the camera's own",
            choices=("", *KELVIN_PER_COUNT),
        ),
        byte_order=fixed("byte_order", "little", "byte order of Mono16 counts", choices=BYTE_ORDERS),
        region=Region(
            pixels("x", "left edge of the strip"),
            pixels("y", "upper edge of the strip"),
            pixels("width", "width of the strip, 0: to the edge"),
            pixels("height", "height of the strip, 0: to the edge"),
        ),
        statistic=fixed("statistic", "mean", "how the region becomes one temperature", choices=STATISTICS),
        lower_k=kelvin("lower_c", -20.0, "lowest plausible temperature; colder frames are dropped"),
        upper_k=kelvin("upper_c", 350.0, "highest plausible temperature; hotter frames are dropped"),
        latency_s=fixed("latency_s", SHEET.latency_s, "age of a frame when it arrives", unit="s", lower=0.0, upper=1.0),
        packet_size=fixed("packet_size", 0, "network packets, 0: the camera's own", unit="byte", lower=0, upper=9000),
        rate_hz=SHEET.rate_hz,
    )
    if 0 in (settings.region.width, settings.region.height) and settings.statistic != "max":
        raise ValueError(
            f"flir.width, flir.height: 0 reaches to the edge of the frame, and the {settings.statistic} of so much "
            "hardly shows how hot a strip in it is; set the region of the strip, or flir.statistic: max"
        )
    return settings


DEVICES: Final[dict[str, DeviceFactory]] = {"flir": flir}


class ThermalCamera(SensorNode):
    """Publishes the temperature of the strip."""

    reports_on = "temperature"

    def __init__(self, **options: Any) -> None:
        super().__init__("thermal_camera", TEMPERATURE, SHEET, DEVICES, **options)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(ThermalCamera, args)


if __name__ == "__main__":
    sys.exit(main())
