# SPDX-License-Identifier: Apache-2.0
"""What the two sensor nodes share: a device chosen by parameter, its simulated form, judgement of silence."""

from collections.abc import Callable, Mapping
from typing import Any

from lce_drivers.sensor import Imperfection, Reading, SensorDevice, SimulatedSensor
from lce_ros.health import Level
from lce_ros.node import BenchNode


class SensorNode(BenchNode):
    """A node that publishes each reading of its device once, and says so in /diagnostics when there is none.

    A device without new readings publishes nothing: an old value is never repeated.
    """

    def __init__(self, name: str, devices: "Mapping[str, DeviceFactory]", **options: Any) -> None:
        super().__init__(name, **options)
        self.declare("stale_after_s", 0.5, "silence that is reported", unit="s", lower=0.05, upper=60.0)
        self._readings = 0
        self._last_s = self.now_s()
        device = self.declare("device", "simulated", "what measures", choices=tuple(devices), read_only=True)
        self._device = devices[device](self)
        self.every(1.0, self._judge)

    def deliver(self, reading: Reading) -> None:
        """Publish a reading; the device calls it, in the node's executor."""
        self.publish(reading)
        self._readings += 1
        self._last_s = self.now_s()

    def deliver_newest(self, reading: Reading | None) -> None:
        """Publish a reading where there is one: the end of a poll."""
        if reading is not None:
            self.deliver(reading)

    def publish(self, reading: Reading) -> None:
        """Put a reading into its message."""
        raise NotImplementedError

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


class Simulated:
    """A sensor of the simulated strip, fed by a topic of the simulator.

    Parameters of the node: noise_rms, quantum [unit of the quantity], latency_s [s], live; seed.
    """

    def __init__(
        self,
        node: SensorNode,
        feed: tuple[Any, str, Callable[[Any], tuple[float, float]]],
        unit: str,
        defaults: Imperfection,
        rate_hz: float,
    ) -> None:
        """``feed`` is message type, topic, and what reads value and time [s] out of a message."""
        msg_type, topic, read = feed
        self._node = node
        node.declare("noise_rms", defaults.noise_rms, "noise", unit=unit, lower=0.0, upper=100.0)
        node.declare("quantum", defaults.quantum, "step of the digits, 0: none", unit=unit, lower=0.0, upper=10.0)
        node.declare("latency_s", defaults.latency_s, "delay of a reading", unit="s", lower=0.0, upper=1.0)
        seed = node.declare("seed", 1, "seed of the noise, -1: a new one each time", lower=-1, read_only=True)
        self._sensor = SimulatedSensor(self._imperfection(), seed, topic, rate_hz)
        node.add_post_set_parameters_callback(lambda _: self._follow_parameters())

        def observe(message: Any) -> None:
            for reading in self._sensor.observe(*read(message)):
                node.deliver(reading)

        node.listen(msg_type, topic, observe)

    def fault(self) -> str | None:
        """Nothing can be wrong with it."""
        return None

    def close(self) -> None:
        """Nothing to let go of."""

    def _imperfection(self) -> Imperfection:
        return Imperfection(*(self._node.value(name) for name in ("noise_rms", "quantum", "latency_s")))

    def _follow_parameters(self) -> None:
        self._sensor.imperfection = self._imperfection()
