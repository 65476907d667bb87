# SPDX-License-Identifier: Apache-2.0
"""Bases of every controller node: its sensor drives it, and timer ticks go on if the sensor falls silent."""

from collections.abc import Callable
from typing import Any, Final, TypeGuard

from std_msgs.msg import Bool, Float64

from lce_control.filters import Sample
from lce_data.topics import ARMED, COMMAND
from lce_ros.node import LceNode

PERIOD_S: Final = 0.01
"""Time between two ticks [s]."""


class ControllerNode(LceNode):
    """A node that steps with each message of the topic that drives it.

    So a measurement becomes a command as soon as it arrives. With a timer it would wait for up to a period in every
    node of a cascade. After three ticks without a message, the node steps at every tick, at 100 Hz, and so notices that
    the sensor is silent.

    Attributes
    ----------
    laser_armed : whether the laser is armed; true until it says otherwise.
    """

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self.laser_armed = True
        self._idle_ticks = 0
        self.listen(Bool, ARMED, self._take_armed, latched=True)
        # Half a period off: at a tick, the sensor's message is on its way through the nodes.
        self.every(PERIOD_S, self._tick, offset_s=PERIOD_S / 2)

    def introduce(self, text: str) -> None:
        """Log what this controller does, in one line at its start."""
        self.get_logger().info(f"{1 / PERIOD_S:g} Hz; {text}")

    def declare_time(self, name: str, default: float, description: str, lower: float, upper: float) -> None:
        """Declare how old [s] something may be; a running node takes a lower one only, or anybody could loosen it."""
        self.declare(name, default, description, unit="s", lower=lower, upper=upper, only_lower=True)

    def declare_temperature_timeout(self) -> None:
        """Declare temperature_timeout_s."""
        self.declare_time("temperature_timeout_s", 0.2, "a temperature older than this is ignored", 0.1, 5.0)

    def driven_by(self, msg_type: Any, topic: str, take: Callable[[Any], None]) -> None:
        """Take in each message of ``topic``, then step."""

        def receive(message: Any) -> None:
            take(message)
            self._idle_ticks = 0
            self.step(self.now_s())

        self.listen(msg_type, topic, receive)

    def is_fresh(self, sample: Sample | None, now_s: float, timeout: str) -> TypeGuard[Sample]:
        """Whether a sample exists and its time differs from now by no more than the parameter ``timeout`` [s]."""
        return sample is not None and abs(now_s - sample.t_s) <= self.value(timeout)

    def step(self, now_s: float) -> None:
        """Decide at ``now_s`` [s], and publish."""
        raise NotImplementedError

    def _take_armed(self, message: Bool) -> None:
        self.laser_armed = message.data

    def _tick(self) -> None:
        self._idle_ticks += 1
        if self._idle_ticks >= 3:  # two may pass before a message that is merely late
            self.step(self.now_s())


class PowerControllerNode(ControllerNode):
    """A controller that commands the laser.

    It commands zero while the laser is not armed, so that somebody can arm it, and as its last word.
    """

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self._command = self.advertise(Float64, COMMAND)

    def close(self) -> None:
        """Leave the laser with a zero."""
        if self.context.ok():
            self.command(0.0)

    def command(self, power_w: float) -> None:
        """Command a power [W]."""
        self._command.publish(Float64(data=power_w))
