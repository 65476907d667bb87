# SPDX-License-Identifier: Apache-2.0
"""Node `distance_sensor`: displacement of the strip's free end.

Publishes   displacement          std_msgs/Float64, m, contraction positive, 100 Hz
            displacement_stamped  lce_interfaces/Float64Stamped, the same; header.stamp is the time of acquisition
Subscribes  sim/displacement      std_msgs/Float64, m, the true one (device simulated only)
Parameters  device                simulated | keyence
            noise_rms, quantum (m), latency_s (s), seed of the simulated sensor
            keyence.*             port, baud_rate, timeout_s, dialect, out, sign, zero, metres, lower_m, upper_m
            stale_after_s         s, silence after which the node warns in /diagnostics
            autostart             configure and activate when the node starts

A managed node (lce_ros.managed_node): configuring it opens the device and waits for a reading, activating it publishes.

The simulated sensor measures each sample of the strip as it comes: a timer of its own would make every recorded
displacement one tick late.
"""

import math
import sys
from typing import Any, Final

from lce_data.channels import DISPLACEMENT
from lce_drivers.background import Background
from lce_drivers.distance.keyence import DIALECTS, KeyenceLink, Mounting, open_port
from lce_drivers.sensor import DataSheet
from lce_drivers.sensor_node import DeviceFactory, SensorNode, SensorOpener
from lce_ros.node import run

SHEET: Final = DataSheet(rate_hz=math.inf, noise_rms=DISPLACEMENT.noise, quantum=1e-6, latency_s=0.0)
POLL_S: Final = 0.01


def keyence(node: SensorNode) -> SensorOpener:
    """A Keyence LK-G5000 or LK-G controller on a serial port."""

    def fixed(name: str, default: Any, description: str, **limits: Any) -> Any:
        return node.declare(f"keyence.{name}", default, description, read_only=True, **limits)

    path = fixed("port", "/dev/ttyUSB0", "serial port")
    baud_rate = fixed("baud_rate", 115200, "baud rate", unit="1/s", lower=1200, upper=921600)
    timeout_s = fixed("timeout_s", 0.1, "longest wait for an answer", unit="s", lower=0.01, upper=1.0)
    dialect = fixed("dialect", "lk_g5000", "series of the controller", choices=tuple(DIALECTS))
    out = fixed("out", 1, "output of the controller", lower=1, upper=12)
    mounting = Mounting(
        sign=fixed("sign", 1.0, "1, or -1 if contraction lowers the display", lower=-1.0, upper=1.0),
        zero=fixed("zero", 0.0, "sign * display of the strip at rest", unit="unit of the display"),
        metres=fixed("metres", 1e-3, "one unit of the display", unit="m", lower=1e-9, upper=1.0),
        lower_m=fixed("lower_m", -0.08, "lowest displacement that is believed", unit="m", lower=-10.0, upper=0.0),
        upper_m=fixed("upper_m", 0.08, "highest displacement that is believed", unit="m", lower=0.0, upper=10.0),
    )
    node.hardware_id = f"keyence {path}"
    node.every(POLL_S, node.poll)
    return lambda: Background(
        lambda: KeyenceLink(open_port(path, baud_rate, timeout_s), dialect, out, mounting, node.now_s),
        "keyence",
    )


DEVICES: Final[dict[str, DeviceFactory]] = {"keyence": keyence}


class DistanceSensor(SensorNode):
    """Publishes the displacement of the strip's free end."""

    reports_on = "displacement"

    def __init__(self, **options: Any) -> None:
        super().__init__("distance_sensor", DISPLACEMENT, SHEET, DEVICES, **options)


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(DistanceSensor, args)


if __name__ == "__main__":
    sys.exit(main())
