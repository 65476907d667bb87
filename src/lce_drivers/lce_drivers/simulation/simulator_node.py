# SPDX-License-Identifier: Apache-2.0
"""Node `simulator`: a strip that lives on the laser power it receives.

Subscribes  laser/power       std_msgs/Float64, W
Publishes   sim/temperature   sensor_msgs/Temperature, °C, 100 Hz, the true state at header.stamp
            sim/displacement  std_msgs/Float64, m, 100 Hz, the true state
            Where the model has effects of the sensors, what sensors without noise would show: a lag or a drift
            belongs to one model file and not to the sensor nodes, which add noise and rate alone.
Parameters  model_file        path of a model file; empty: the default model
            set               TERM.PARAM=VALUE, any number: parameters of the model that differ from it
            power_timeout_s   s, a laser power older than this counts as zero

It publishes once it has found a laser. Every step is as long as the node's clock says, so the strip neither
slows down nor hurries when ticks come late.
"""

import math
import sys
from typing import Any, Final

from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_drivers.simulation.strip import Drive, strip_model
from lce_model import Stepper
from lce_ros.conversions import to_celsius, to_stamp
from lce_ros.health import Level
from lce_ros.node import BenchNode, run

PERIOD_S: Final = 0.01


class Simulator(BenchNode):
    """Steps one model through the node's time."""

    def __init__(self, **options: Any) -> None:
        super().__init__("simulator", **options)
        model_file = self.declare("model_file", "", "model file, empty: the default model", read_only=True)
        settings = self.declare("set", [""], "TERM.PARAM=VALUE of the model", read_only=True)
        timeout_s = self.declare(
            "power_timeout_s", 0.1, "age at which a laser power counts as zero", unit="s",
            lower=0.02, upper=10.0, read_only=True,
        )  # fmt: skip
        self._drive = Drive(timeout_s)
        self._strip = Stepper(strip_model(model_file, settings))
        self._strip.step(0.0, 0.0)
        self._temperature = self.advertise(Temperature, "sim/temperature")
        self._displacement = self.advertise(Float64, "sim/displacement")
        self._laser_found = False
        self._power = self.listen(Float64, "laser/power", lambda m: self._drive.put(m.data, self.now_s()))
        self.every(PERIOD_S, self._tick)
        self.every(1.0, self._report_state)

    def _tick(self) -> None:
        # Nodes find each other pair by pair, seconds apart: a first sample of the strip is to mean that it
        # has found its laser, so that who waits for the sensors waits for the whole chain.
        self._laser_found = self._laser_found or self._power.get_publisher_count() > 0
        if not self._laser_found:
            return
        for power_w, dt_s in self._drive.advance(self.tick_s):
            self._strip.step(power_w, dt_s)
        message = Temperature(temperature=to_celsius(self._strip.measured_temperature_k))
        message.header.stamp = to_stamp(self.tick_s)
        message.header.frame_id = "strip"
        self._temperature.publish(message)
        if not math.isnan(self._strip.measured_displacement_m):
            self._displacement.publish(Float64(data=self._strip.measured_displacement_m))

    def _report_state(self) -> None:
        if not self._laser_found:
            self.report(Level.WARN, "no laser yet: the strip waits for it")
            return
        self.report(
            Level.OK,
            "running",
            power_w=self._drive.power_w,
            temperature_c=to_celsius(self._strip.temperature_k),
            displacement_mm=self._strip.displacement_m * 1e3,
        )


def main(args: list[str] | None = None) -> int:
    """Entry point of the executable; the exit status."""
    return run(Simulator, args)


if __name__ == "__main__":
    sys.exit(main())
