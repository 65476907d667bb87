# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench, relative to its namespace; the recorder records them by default."""

from collections.abc import Mapping

from lce_data.channels import CHANNELS, SENSORS, Channel

COMMAND = "laser/power_command"
ARMED = "laser/armed"
SETPOINT = "temperature_setpoint"
TARGET = "target_displacement"
DIAGNOSTICS = "/diagnostics"


def simulated_topic(channel: Channel) -> str:
    """Topic on which the simulator publishes what a sensor without noise would show of a channel."""
    return f"sim/{channel.topic}"


RECORDED: Mapping[str, str] = {
    COMMAND: "std_msgs/msg/Float64",
    **{channel.topic: channel.message for channel in CHANNELS},
    SETPOINT: "sensor_msgs/msg/Temperature",
    TARGET: "std_msgs/msg/Float64",
    **{simulated_topic(channel): channel.message for channel in SENSORS},
    DIAGNOSTICS: "diagnostic_msgs/msg/DiagnosticArray",
}
"""Message type by topic, of every topic that is recorded by default; what nobody publishes is not in the bag."""

LATCHED_TOPICS = frozenset({TARGET})
"""Topics whose last message also reaches a subscriber that joins later."""
