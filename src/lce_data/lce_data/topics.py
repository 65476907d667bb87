# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench, relative to its namespace; the recorder records them by default."""

from collections.abc import Mapping

from lce_data.channels import CHANNELS, NUMBER, SENSORS, STAMPED_NUMBER, Channel, stamped_topic

COMMAND = "laser/power_command"
COMMAND_STAMPED = stamped_topic(COMMAND)
ARMED = "laser/armed"
SETPOINT = "temperature_setpoint"
TARGET = "target_displacement"
DIAGNOSTICS = "/diagnostics"
MARKER = "marker"
"""Events of a run that somebody marks: a time and a short text, as a line of a log."""
LOG = "rcl_interfaces/msg/Log"


def simulated_topic(channel: Channel) -> str:
    """Topic on which the simulator publishes what a sensor without noise would show of a channel."""
    return f"sim/{channel.topic}"


RECORDED: Mapping[str, str] = {
    COMMAND: NUMBER,
    COMMAND_STAMPED: STAMPED_NUMBER,
    **{channel.topic: channel.message for channel in CHANNELS},
    **{channel.stamped_topic: STAMPED_NUMBER for channel in CHANNELS if channel.stamped_topic},
    SETPOINT: "sensor_msgs/msg/Temperature",
    TARGET: NUMBER,
    **{simulated_topic(channel): channel.message for channel in SENSORS},
    DIAGNOSTICS: "diagnostic_msgs/msg/DiagnosticArray",
    MARKER: LOG,
}
"""Message type by topic, of every topic that is recorded by default; what nobody publishes is not in the bag."""

LATCHED_TOPICS = frozenset({TARGET})
"""Topics whose last message also reaches a subscriber that joins later."""
