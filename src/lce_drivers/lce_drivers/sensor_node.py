# SPDX-License-Identifier: Apache-2.0
"""What the sensor nodes share: a channel, a device chosen by parameter, judgement of silence."""

from collections.abc import Callable, Mapping
from typing import Any

from lce_data.channels import Channel
from lce_drivers.sensor import DataSheet, Reading, SensorDevice
from lce_ros.health import Level
from lce_ros.messages import message_class, to_message
from lce_ros.node import LceNode


class SensorNode(LceNode):
    """A node that publishes each reading of its device once, and warns in /diagnostics when readings stop.

    A device without new readings publishes nothing: an old value is never repeated.

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
        self._readings = 0
        self._last_s = self.now_s()
        factories = {"simulated": simulated, **devices}
        device = self.declare("device", "simulated", "what measures", choices=tuple(factories), read_only=True)
        self._device = factories[device](self)
        self.every(1.0, self._judge)
        self._values = self.advertise(message_class(channel), channel.topic)

    def deliver(self, reading: Reading) -> None:
        """Publish a reading; the device calls it, in the node's executor."""
        self._values.publish(to_message(self.channel, reading.value, reading.t_s, reading.variance))
        self._readings += 1
        self._last_s = self.now_s()

    def deliver_newest(self, reading: Reading | None) -> None:
        """Publish the reading of a poll if it brought one."""
        if reading is not None:
            self.deliver(reading)

    def close(self) -> None:
        """Let go of the device."""
        self._device.close()

    def _judge(self) -> None:
        silence_s = self.now_s() - self._last_s
        fault = self._device.fault()
        if fault is not None:
            self.report(Level.ERROR, fault, readings=self._readings)
        elif silence_s > self.value("stale_after_s"):
            self.report(Level.WARN, f"no reading for {silence_s:.1f} s", readings=self._readings)
        else:
            self.report(Level.OK, "measuring", readings=self._readings)


DeviceFactory = Callable[[SensorNode], SensorDevice]


def simulated(node: SensorNode) -> SensorDevice:
    """The sensor of the simulated strip; a node with a real device never loads it."""
    from lce_drivers.simulation.sensor_device import SimulatedDevice

    return SimulatedDevice(node)
