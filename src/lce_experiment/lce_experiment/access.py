# SPDX-License-Identifier: Apache-2.0
"""What every node of the bench publishes, reads, serves and calls: all that it may do in a secured graph.

Names are relative to the namespace of the bench; the test of this table starts every node and compares.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from lce_data.channels import AMBIENT, DISPLACEMENT, LOAD, POWER, SENSORS, TEMPERATURE
from lce_data.topics import ARMED, COMMAND, DIAGNOSTICS, RECORDED, SETPOINT, TARGET, simulated_topic
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


ACCESS: Final[Mapping[str, Access]] = {
    LASER.name: Access((POWER.topic, ARMED), (COMMAND, TEMPERATURE.topic), serves=(ARM, RESET)),
    SIMULATOR.name: Access(SIMULATED, (POWER.topic, AMBIENT.topic, LOAD.topic, "input/*")),
    **{
        node.name: Access((channel.topic,), (simulated_topic(channel),))
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
    publishes=(TARGET,),
    subscribes=(*RECORDED, ARMED, "input/*", "/rosout", "/parameter_events"),
    calls=(ARM, RESET, INVERSE, *(f"{name}/{service[2:]}" for name in ACCESS for service in EVERY_NODE.serves)),
)
"""The human's tools: they arm, reset, set parameters and targets, and see everything. They do not command the laser."""

MONITOR: Final = Access(subscribes=OPERATOR.subscribes)
"""Who looks and records, and changes nothing."""
