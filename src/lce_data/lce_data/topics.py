# SPDX-License-Identifier: Apache-2.0
"""What the recorder records unless told otherwise: the topics of the bench, relative to the namespace."""

from collections.abc import Mapping

COMMAND = "laser/power_command"
TARGET = "target_displacement"

RECORDED: Mapping[str, str] = {
    COMMAND: "std_msgs/msg/Float64",
    "laser/power": "std_msgs/msg/Float64",
    "temperature": "sensor_msgs/msg/Temperature",
    "displacement": "std_msgs/msg/Float64",
    "temperature_setpoint": "sensor_msgs/msg/Temperature",
    TARGET: "std_msgs/msg/Float64",
    "sim/temperature": "sensor_msgs/msg/Temperature",
    "sim/displacement": "std_msgs/msg/Float64",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}
"""Topic and message type."""

LATCHED_TOPICS = frozenset({TARGET})
"""Those that are said once and kept for who comes later."""
