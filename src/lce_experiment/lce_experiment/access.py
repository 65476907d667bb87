# SPDX-License-Identifier: Apache-2.0
"""What every node of the bench publishes, reads, serves and calls: all that it may do in a secured graph.

Names are relative to the namespace of the bench; the test of this table starts every node and compares.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from lce_data.channels import AMBIENT, DISPLACEMENT, LOAD, POWER, SENSORS, TEMPERATURE, Channel
from lce_data.topics import (
    ARMED,
    COMMAND,
    COMMAND_STAMPED,
    DIAGNOSTICS,
    MARKER,
    RECORDED,
    SETPOINT,
    TARGET,
    simulated_topic,
)
from lce_experiment.registry import (
    FEEDFORWARD,
    INNER,
    LASER,
    MODEL,
    OUTER,
    PLAYER,
    RECORDER,
    SIMULATOR,
    SINGLE,
    TARGET_PLAYER,
)
from lce_experiment.registry import SENSORS as SENSOR_NODES

ARM: Final = "laser/arm"
RESET: Final = "laser/reset"
INVERSE: Final = "inverse_temperature"
SIMULATED: Final = tuple(simulated_topic(channel) for channel in SENSORS)


@dataclass(frozen=True)
class Access:
    """Topics and services of a node, beside those that every node has."""

    publishes: tuple[str, ...] = ()
    subscribes: tuple[str, ...] = ()
    serves: tuple[str, ...] = ()
    calls: tuple[str, ...] = ()


MANAGED: Final = Access(
    publishes=("~/transition_event",),
    serves=tuple(
        f"~/{service}"
        for service in (
            "change_state",
            "get_state",
            "get_available_states",
            "get_available_transitions",
            "get_transition_graph",
        )
    ),
)
"""What rclpy gives a managed node."""


def _measured(channel: Channel) -> tuple[str, ...]:
    """The topics on which a channel is published."""
    return (channel.topic, channel.stamped_topic) if channel.stamped_topic else (channel.topic,)


ACCESS: Final[Mapping[str, Access]] = {
    LASER.name: Access(
        (*_measured(POWER), COMMAND_STAMPED, ARMED, *MANAGED.publishes),
        (COMMAND, TEMPERATURE.topic),
        serves=(ARM, RESET, *MANAGED.serves),
    ),
    SIMULATOR.name: Access(SIMULATED, (POWER.topic, AMBIENT.topic, LOAD.topic, "input/*")),
    **{
        node.name: Access((*_measured(channel), *MANAGED.publishes), (simulated_topic(channel),), MANAGED.serves)
        for node, channel in zip(SENSOR_NODES, SENSORS, strict=True)
    },
    FEEDFORWARD.name: Access(subscribes=(TEMPERATURE.topic,), serves=(INVERSE,)),
    OUTER.name: Access((SETPOINT,), (DISPLACEMENT.topic, ARMED, TARGET, TEMPERATURE.topic), calls=(INVERSE,)),
    INNER.name: Access((COMMAND,), (ARMED, TEMPERATURE.topic, SETPOINT)),
    SINGLE.name: Access((COMMAND,), (DISPLACEMENT.topic, ARMED, TARGET), calls=(INVERSE,)),
    MODEL.name: Access((COMMAND,), (DISPLACEMENT.topic, ARMED, POWER.topic, TARGET, TEMPERATURE.topic)),
    PLAYER.name: Access((COMMAND,), (ARMED, DIAGNOSTICS)),
    TARGET_PLAYER.name: Access((TARGET,), (ARMED, DIAGNOSTICS)),
    RECORDER.name: Access(subscribes=(*RECORDED, "input/*")),
}
"""By the name of the node."""

MANAGED_NODES: Final = (LASER.name, *(node.name for node in SENSOR_NODES))
"""The nodes that hold a device."""


EVERY_NODE: Final = Access(
    publishes=("/rosout", "/parameter_events", DIAGNOSTICS),
    serves=tuple(
        f"~/{service}"
        for service in (
            "describe_parameters",
            "get_parameter_types",
            "get_parameters",
            "list_parameters",
            "set_parameters",
            "set_parameters_atomically",
            "get_type_description",
        )
    ),
)
"""What rclpy gives every node, and its diagnosis; ~ is the node itself."""

OPERATOR: Final = Access(
    publishes=(TARGET, MARKER),
    subscribes=(
        *RECORDED,
        ARMED,
        "input/*",
        "/rosout",
        "/parameter_events",
        *(f"{name}/{topic[2:]}" for name in MANAGED_NODES for topic in MANAGED.publishes),
    ),
    calls=(
        ARM,
        RESET,
        INVERSE,
        *(f"{name}/{service[2:]}" for name in ACCESS for service in EVERY_NODE.serves),
        *(f"{name}/{service[2:]}" for name in MANAGED_NODES for service in MANAGED.serves),
    ),
)
"""The human's tools, the page among them: they arm, reset, take nodes through their states, set parameters and targets,
mark events, and see everything.

They do not command the laser."""

MONITOR: Final = Access(subscribes=OPERATOR.subscribes)
"""Who looks and records, and changes nothing."""
