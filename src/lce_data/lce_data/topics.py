# SPDX-License-Identifier: Apache-2.0
"""What the recorder records unless told otherwise: the topics of the bench, relative to the namespace."""

from collections.abc import Mapping

from lce_data.channels import CHANNELS, SENSORS, Channel

COMMAND = "laser/power_command"
TARGET = "target_displacement"


def simulated_topic(channel: Channel) -> str:
    """Where the simulator publishes what a channel's sensor without noise would show."""
    return f"sim/{channel.topic}"


RECORDED: Mapping[str, str] = {
    COMMAND: "std_msgs/msg/Float64",
    **{channel.topic: channel.message for channel in CHANNELS},
    "temperature_setpoint": "sensor_msgs/msg/Temperature",
    TARGET: "std_msgs/msg/Float64",
    **{simulated_topic(channel): channel.message for channel in SENSORS},
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}
"""Topic and message type."""

LATCHED_TOPICS = frozenset({TARGET})
"""Topics whose last message reaches a subscriber that comes later."""
