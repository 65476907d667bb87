# SPDX-License-Identifier: Apache-2.0
"""A sensor of the simulated strip behind a sensor node: the same for every channel."""

from typing import Any

from lce_data.topics import simulated_topic
from lce_drivers.sensor import DeviceNode
from lce_drivers.simulation.sensor import Imperfection, SimulatedSensor
from lce_ros.messages import from_message, message_class


class SimulatedDevice:
    """A SensorDevice fed by the simulator's topic of the node's channel.

    Declares the node's parameters noise_rms, quantum [SI unit of the channel] and latency_s [s] (all live).
    """

    def __init__(self, node: DeviceNode) -> None:
        channel, sheet, topic = node.channel, node.sheet, simulated_topic(node.channel)
        self._node = node
        node.declare(
            "noise_rms", sheet.noise_rms, "standard deviation of the noise", unit=channel.unit, lower=0.0, upper=100.0
        )
        node.declare(
            "quantum", sheet.quantum, "step of the digits, 0: not rounded", unit=channel.unit, lower=0.0, upper=10.0
        )
        node.declare("latency_s", sheet.latency_s, "time from acquisition to reading", unit="s", lower=0.0, upper=1.0)
        self._sensor = SimulatedSensor(self._imperfection(), node.value("seed"), topic, sheet.rate_hz)
        node.add_post_set_parameters_callback(lambda _: self._follow_parameters())
        node.listen(message_class(channel), topic, self._observe)

    def check(self) -> None:
        """It is always there; its readings come with the simulated strip."""

    def poll(self) -> None:
        """Its readings are handed to the node."""

    def fault(self) -> str | None:
        """Nothing can be wrong with it."""
        return None

    def close(self) -> None:
        """Nothing to let go of."""

    def _observe(self, message: Any) -> None:
        value, measured_s = from_message(self._node.channel, message)
        for reading in self._sensor.observe(value, self._node.sent_s if measured_s is None else measured_s):
            self._node.deliver(reading)

    def _imperfection(self) -> Imperfection:
        return Imperfection(*(self._node.value(name) for name in ("noise_rms", "quantum", "latency_s")))

    def _follow_parameters(self) -> None:
        self._sensor.imperfection = self._imperfection()
