# SPDX-License-Identifier: Apache-2.0
"""The target that a controller follows: shared by the nodes that subscribe to `target_displacement`."""

import math
from typing import Final

from rclpy.task import Future
from std_msgs.msg import Float64

from lce_data.topics import TARGET
from lce_interfaces.srv import InverseTemperature
from lce_ros.conversions import to_kelvin
from lce_ros.health import Level
from lce_ros.node import LceNode

ANSWER_TIMEOUT_S: Final = 1.0
"""The service is asked again if its answer takes longer [s]."""
WAITS: Final = "waits for the service inverse_temperature"
TOLD_S: Final = 1.0
"""A new target is logged at most so often [s]: a trajectory is many of them."""


class TargetTracker:
    """The newest target that the strip can reach, and its temperature by the service `inverse_temperature`.

    A target out of reach is refused, and the target before it stays.

    Attributes
    ----------
    target_m : the target [m]; NaN before the first one.
    temperature_k : its feed-forward temperature [K]; NaN before the first target.
    """

    def __init__(self, node: LceNode) -> None:
        self.target_m = self.temperature_k = math.nan
        self._refusal: str | None = None
        self._node = node
        self._wanted_m: float | None = None
        self._asked: Future | None = None
        self._asking_m = math.nan
        self._asked_s = -math.inf
        self._waiting_since_s: float | None = None
        self._waits = False
        node.listen(Float64, TARGET, self._take_target, latched=True)
        self._client = node.create_client(InverseTemperature, "inverse_temperature")

    @property
    def exists(self) -> bool:
        """Whether there is a target to follow."""
        return not math.isnan(self.target_m)

    @property
    def missing(self) -> tuple[Level, str]:
        """Why there is no target to follow, and how bad that is."""
        return (Level.WARN, f"a target {WAITS}") if self._waits else (Level.OK, "no target")

    @property
    def complaint(self) -> tuple[Level, str] | None:
        """Why the newest target is not the one that is followed, and how bad that is; None if it is."""
        if self._waits and self.exists:
            return Level.WARN, f"a new target {WAITS}; {self._stays}"
        return None if self._refusal is None else (Level.ERROR, self._refusal)

    @property
    def _stays(self) -> str:
        return f"{self.target_m * 1e3:.3f} mm stays the target" if self.exists else "there is no target"

    def update(self, t_s: float) -> None:
        """Ask the service about a new target; to be called in every step, at ``t_s`` [s]."""
        if self._asked is not None and not 0.0 <= t_s - self._asked_s < ANSWER_TIMEOUT_S:
            self._client.remove_pending_request(self._asked)
            self._asked = None
            if self._wanted_m is None:
                self._wanted_m = self._asking_m
        if self._asked is None and self._wanted_m is not None and self._client.service_is_ready():
            self._ask(self._wanted_m, t_s)
        self._waits = self._is_waiting(t_s)

    def _is_waiting(self, t_s: float) -> bool:
        """Is there a target, and no answer: because the service is not there, or none came for longer than usual?"""
        if self._asked is None and self._wanted_m is None:
            self._waiting_since_s = None
            return False
        if self._waiting_since_s is None:
            self._waiting_since_s = t_s
        late = not 0.0 <= t_s - self._waiting_since_s < ANSWER_TIMEOUT_S
        return late or not self._client.service_is_ready()

    def _ask(self, target_m: float, t_s: float) -> None:
        self._wanted_m, self._asking_m, self._asked_s = None, target_m, t_s
        self._asked = self._client.call_async(InverseTemperature.Request(displacement=target_m))
        self._asked.add_done_callback(lambda future: self._answered(target_m, future.result()))

    def _take_target(self, message: Float64) -> None:
        self._wanted_m = message.data

    def _answered(self, wanted_m: float, answer: InverseTemperature.Response) -> None:
        self._asked = self._waiting_since_s = None
        if answer.success:
            self.target_m, self.temperature_k, self._refusal = wanted_m, to_kelvin(answer.temperature), None
            told = f"target {wanted_m * 1e3:.3f} mm, feed-forward {answer.temperature:.2f} °C"
            self._node.get_logger().info(told, throttle_duration_sec=TOLD_S)
            return
        self._refusal = f"target refused: {answer.message}; {self._stays}"
        self._node.tell(Level.ERROR, self._refusal, again=True)
        self._node.report(Level.ERROR, self._refusal)
