# SPDX-License-Identifier: Apache-2.0
"""What every controller node shares: it is driven by its sensor, and does not fall silent with it."""

from collections.abc import Callable
from typing import Any, Final, TypeGuard

from lce_control.filters import Sample
from lce_ros.node import BenchNode

PERIOD_S: Final = 0.01


class ControllerNode(BenchNode):
    """A node that steps with each message of the topic that drives it, and at every tick once none came for three.

    A measurement so becomes a command as soon as it is there; a timer of its own would let it wait for up to a period
    in every node of a cascade. The ticks go on at 100 Hz where the sensor is silent, and notice that.
    """

    def __init__(self, name: str, **options: Any) -> None:
        super().__init__(name, **options)
        self._idle_ticks = 0
        # Half a period off: not while the sensor's message, sent at a tick, is on its way through the nodes.
        self.every(PERIOD_S, self._tick, offset_s=PERIOD_S / 2)

    def driven_by(self, msg_type: Any, topic: str, take: Callable[[Any], None]) -> None:
        """Take in each message of ``topic``, then step."""

        def receive(message: Any) -> None:
            take(message)
            self._idle_ticks = 0
            self.step(self.now_s())

        self.listen(msg_type, topic, receive)

    def is_fresh(self, sample: Sample | None, now_s: float, timeout: str) -> TypeGuard[Sample]:
        """Whether a sample is there that is not older than the parameter ``timeout`` [s], nor as far in the future."""
        return sample is not None and abs(now_s - sample.t_s) <= self.value(timeout)

    def step(self, now_s: float) -> None:
        """Judge what is known at ``now_s`` [s], and publish."""
        raise NotImplementedError

    def _tick(self) -> None:
        self._idle_ticks += 1
        if self._idle_ticks >= 3:  # two may pass before a message that is merely late
            self.step(self.now_s())
