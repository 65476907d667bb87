# SPDX-License-Identifier: Apache-2.0
"""Node `simulator`: a strip that lives on the laser power it receives.

Subscribes  laser/power       std_msgs/Float64, W
            the topics of the optional inputs that effects of the model read, held until the next message:
            ambient_temperature  sensor_msgs/Temperature, °C
            load              std_msgs/Float64, N
            input/NAME        std_msgs/Float64, what a user named
Publishes   sim/TOPIC         for each sensor of lce_data.channels, in the message of its channel, 100 Hz: what a
                              sensor without noise would show. An effect of a sensor (a lag, a drift) belongs to the
                              model file; the sensor nodes add noise and rate alone.
            sim/temperature   sensor_msgs/Temperature, °C, true at header.stamp
            sim/displacement  std_msgs/Float64, m
Parameters  model_file        path of a model file; empty: the default model
            set               TERM.PARAM=VALUE, any number: parameters of the model that differ from it
            power_timeout_s   s, maximum age of a laser power; an older one counts as zero

It publishes once it has found a laser. Every step is as long as the node's clock says, so the strip neither
slows down nor hurries when ticks come late.
"""

import functools
import math
import sys
from typing import Any, Final

from lce_data.channels import POWER, SENSORS, Channel
from lce_data.settings import parse_settings
from lce_data.topics import simulated_topic
from lce_drivers.simulation.strip import Drive, strip_model
from lce_model import Stepper
from lce_ros.conversions import to_celsius
from lce_ros.health import Level
from lce_ros.messages import from_message, message_class, to_message
from lce_ros.node import LceNode, run
from lce_ros.signals import interruptible

PERIOD_S: Final = 0.01


class Simulator(LceNode):
    """Steps one model through the node's time."""

    reports_on = "strip"

    def __init__(self, **options: Any) -> None:
        super().__init__("simulator", **options)
        self.hardware_id = "simulated"
        model_file = self.declare("model_file", "", "model file, empty: the default model", read_only=True)
        settings = self.declare("set", [""], "TERM.PARAM=VALUE of the model", read_only=True)
        timeout_s = self.declare(
            "power_timeout_s", 0.1, "maximum age of a laser power; an older one counts as zero", unit="s",
            lower=0.02, upper=10.0, read_only=True,
        )  # fmt: skip
        self._drive = Drive(timeout_s)
        model = strip_model(model_file, parse_settings(settings))
        with interruptible():  # the first time, the kernel of the model is compiled
            self._strip = Stepper(model)
        self._strip.step(0.0, 0.0)
        self._sensors = [
            (channel, channel.output, self.advertise(message_class(channel), simulated_topic(channel)))
            for channel in SENSORS
            if channel.output is not None
        ]
        self._laser_found = False
        self._power = self.listen(message_class(POWER), POWER.topic, self._take_power)
        for channel in model.inputs:
            self.listen(message_class(channel), channel.topic, functools.partial(self._take_input, channel))
        self.every(PERIOD_S, self._tick)
        self.every(1.0, self._report_state)
        strip = model_file or "the default strip"
        self.get_logger().info(f"{strip}: {1.0 / PERIOD_S:g} Hz; a power older than {timeout_s:g} s counts as zero")

    def _take_power(self, message: Any) -> None:
        # As old as its publisher says: after a stall of this process, a dead laser's last words wait in the queue.
        self._drive.put(from_message(POWER, message)[0], min(self.sent_s, self.now_s()))

    def _take_input(self, channel: Channel, message: Any) -> None:
        value, _ = from_message(channel, message)
        if math.isfinite(value):
            self._strip.set_inputs({channel: value})

    def _tick(self) -> None:
        # Nodes find each other pair by pair, seconds apart. The first sample of the strip means that it has found its
        # laser: a node that waits for the sensors so waits for the whole chain.
        self._laser_found = self._laser_found or self._power.get_publisher_count() > 0
        if not self._laser_found:
            return
        for power_w, dt_s in self._drive.advance(self.tick_s):
            self._strip.step(power_w, dt_s)
        for channel, output, publisher in self._sensors:
            value = self._strip.signal(output)
            if not math.isnan(value):  # the model has no such stage
                publisher.publish(to_message(channel, value, self.tick_s))

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
