# SPDX-License-Identifier: Apache-2.0
"""Quality of service, chosen once for the whole bench.

STREAM, for every command and measurement: reliable, because a lost 100 Hz sample is a hole in a recording and
nothing here is large; ten deep, 100 ms of a 100 Hz stream, so that a short stall loses nothing and a long one
does not deliver old commands; volatile, because an old sample is worthless to a node that starts.

LATCHED, for a value that holds until it is changed (target_displacement): transient local, one deep. Who listens to it
subscribes twice, with each of LATCHED_LISTENERS: DDS matches a transient-local subscriber with no volatile publisher,
as ``ros2 topic pub`` is by default, and gives a volatile subscriber no message from before its time.

No deadline, lifespan or liveliness: a subscriber that asks for one receives nothing from a publisher that offers none
(``ros2 topic pub``, ``ros2 bag play``, Foxglove), their clocks know nothing of simulated time, and deadline events
come only after a first sample. Instead each node judges the age of what it received on its own clock.
Publishers here offer what any subscriber asks for by default: ``ros2 topic echo``, bags and Foxglove need no
QoS options.
"""

from typing import Final

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def _reliable(depth: int, durability: DurabilityPolicy) -> QoSProfile:
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        durability=durability,
    )


STREAM: Final = _reliable(10, DurabilityPolicy.VOLATILE)
LATCHED: Final = _reliable(1, DurabilityPolicy.TRANSIENT_LOCAL)
LATCHED_LISTENERS: Final = (LATCHED, _reliable(1, DurabilityPolicy.VOLATILE))
"""The first receives what was published before it, the second matches every publisher."""


def deeper(depth: int) -> QoSProfile:
    """STREAM for a subscriber that must not lose a sample while it is busy: a recorder."""
    return _reliable(depth, DurabilityPolicy.VOLATILE)
