# SPDX-License-Identifier: Apache-2.0
"""What the sensor nodes share: a channel, a device chosen by parameter, judgement of silence."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from lce_data.channels import Channel
from lce_data.topics import DIAGNOSTICS
from lce_drivers.background import NOT_YET
from lce_drivers.sensor import DataSheet, Reading, SensorDevice
from lce_interfaces.msg import Float64Stamped
from lce_ros.health import Level
from lce_ros.managed_node import ManagedNode
from lce_ros.messages import message_class, stamped_number, to_message


class SensorNode(ManagedNode):
    """A node that publishes each reading of its device once, and warns in /diagnostics when readings stop.

    Beside a topic whose messages have no stamp stands a stamped one, with the time of acquisition. A device without
    new readings publishes nothing: an old value is never repeated.

    Parameters
    ----------
    channel : what it measures; topic and message are the channel's.
    sheet : the data sheet of its sensor.
    devices : real devices by the name that the parameter ``device`` gives them; every channel also has ``simulated``.
    """

    def __init__(
        self,
        name: str,
        channel: Channel,
        sheet: DataSheet,
        devices: "Mapping[str, DeviceFactory]",
        **options: Any,
    ) -> None:
        super().__init__(name, **options)
        self.channel = channel
        self.sheet = sheet
        self.declare("stale_after_s", 0.5, "silence after which the node warns", unit="s", lower=0.05, upper=60.0)
        self.declare("seed", 1, "of a simulated sensor's noise, -1: a new one each time", lower=-1, read_only=True)
        self._readings = 0
        self._last_s = self.now_s()
        factories = {"simulated": simulated, **devices}
        device = self.declare("device", "simulated", "what measures", choices=tuple(factories), read_only=True)
        self.hardware_id = device
        self._open = factories[device](self)
        self._device: SensorDevice | None = None
        self.every(1.0, self._judge)
        self._values = self.advertise(message_class(channel), channel.topic)
        beside = channel.stamped_topic
        self._stamped = self.advertise(Float64Stamped, beside) if beside else None
        self.start()

    def deliver(self, reading: Reading) -> None:
        """Publish a reading while the node is active; to be called in the node's executor."""
        if not self.active:
            return
        self._values.publish(to_message(self.channel, reading.value, reading.t_s, reading.variance))
        if self._stamped is not None:
            self._stamped.publish(stamped_number(self.channel.recorded.from_si(reading.value), reading.t_s))
        self._readings += 1
        self._last_s = self.now_s()

    def poll(self) -> None:
        """Publish what the device has read since the last call."""
        reading = None if self._device is None else self._device.poll()
        if reading is not None:
            self.deliver(reading)

    def open_device(self) -> None:
        """Open the device and wait for a reading; a node that starts itself connects whenever the device is there."""
        self._device = self._open()
        if self.autostart:
            return
        try:
            self._device.check()
        except OSError:
            self.close_device()
            raise

    def begin(self) -> None:
        """Publish from now on."""
        self._last_s = self.now_s()
        rate = f"{self.sheet.rate_hz:g} Hz" if math.isfinite(self.sheet.rate_hz) else "100 Hz"
        self.get_logger().info(
            f"{self.hardware_id}: {self._values.topic_name}, {rate}; "
            f"warns in {DIAGNOSTICS} after {self.value('stale_after_s'):g} s of silence"
        )

    def close_device(self) -> None:
        """Let go of the device."""
        device, self._device = self._device, None
        if device is not None:
            device.close()

    def _judge(self) -> None:
        if self._device is None or not self.active:
            return
        silence_s = self.now_s() - self._last_s
        fault = self._device.fault()
        if fault is not None:
            self.report(Level.WARN if fault == NOT_YET else Level.ERROR, fault, readings=self._readings)
        elif silence_s > self.value("stale_after_s"):
            self.report(Level.WARN, f"no reading for {silence_s:.1f} s", readings=self._readings)
        else:
            self.report(Level.OK, "measuring", readings=self._readings)


SensorOpener = Callable[[], SensorDevice]
"""Opens the device: a real one connects in a thread of its own, again and again until it is there."""
DeviceFactory = Callable[[SensorNode], SensorOpener]
"""Declares the parameters of a device."""


def simulated(node: SensorNode) -> SensorOpener:
    """The sensor of the simulated strip; a node with a real device never loads it."""
    from lce_drivers.simulation.sensor_device import SimulatedDevice

    device = SimulatedDevice(node)
    return lambda: device
