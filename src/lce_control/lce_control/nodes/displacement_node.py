# SPDX-License-Identifier: Apache-2.0
"""The displacement that a controller follows, and why there is none: shared by the nodes of the outer loops."""

import math

from std_msgs.msg import Float64

from lce_control.displacement_watch import DisplacementWatch
from lce_control.filters import Sample
from lce_control.nodes.controller_node import ControllerNode
from lce_data.channels import DISPLACEMENT
from lce_ros.health import FAULT


class DisplacementInput:
    """Subscribes to `displacement`, which drives the node, and judges the sensor while a target is followed.

    Declares displacement_timeout_s, displacement_fault_s and frozen_after_s. A fault stays until the laser is disarmed;
    light then needs a person who arms it.

    Attributes
    ----------
    newest : the newest finite displacement [m], with the time [s] at which it was sent; None before the first.
    missing : why the last `at` gave none.
    """

    def __init__(self, node: ControllerNode) -> None:
        node.declare_time("displacement_timeout_s", 0.1, "a displacement older than this is ignored", 0.02, 1.0)
        node.declare_time("displacement_fault_s", 0.5, "a silence of the displacement that is a fault", 0.1, 10.0)
        node.declare("frozen_after_s", 0.15, "a displacement that repeats itself for so long is a fault; 0: never",
                     unit="s", lower=0.0, upper=60.0, read_only=True)  # fmt: skip
        self.newest: Sample | None = None
        self.missing = ""
        self._node = node
        self._watch = DisplacementWatch()
        node.driven_by(Float64, DISPLACEMENT.topic, self._take)

    def at(self, now_s: float, followed: bool) -> Sample | None:
        """The displacement to act on at ``now_s`` [s]; None if it is too old or its sensor has a fault.

        ``followed`` says whether a target is followed.
        """
        self._watch.silent_after_s = self._node.value("displacement_fault_s")
        self._watch.frozen_after_s = self._node.value("frozen_after_s")
        if not self._node.laser_armed:
            self._watch.reset()
        elif followed and not self._watch.fault and self._watch.judge(now_s):
            stop = "" if self._watch.fault.endswith("?") else "."
            self._node.get_logger().error(f"{self._watch.fault}{stop} Disarm the laser and arm it to go on.")
        self.missing = f"{FAULT}{self._watch.fault}" if self._watch.fault else "no fresh displacement"
        fresh = self._node.is_fresh(self.newest, now_s, "displacement_timeout_s")
        return self.newest if fresh and not self._watch.fault else None

    def _take(self, message: Float64) -> None:
        if math.isfinite(message.data):
            # A queue that waited for a stopped controller is as old as its messages.
            self.newest = Sample(message.data, min(self._node.sent_s, self._node.now_s()))
            self._watch.take(self.newest)
