# SPDX-License-Identifier: Apache-2.0
"""The nodes of an experiment on the simulated strip: one entry a node, the same for every runner."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, cast

if TYPE_CHECKING:  # the command line reads this table without ROS
    from lce_ros.node import LceNode

NAMESPACE: Final = "/lce"

SIGINT_BLOCKED: Final = ("env", "--block-signal=INT")
"""Before the command line of a node: Ctrl-C waits until the node handles it (lce_ros.executable), and so never strikes
the start of Python itself."""


def arm_call(namespace: str = NAMESPACE) -> tuple[str, ...]:
    """The command that arms the laser of a namespace."""
    return ("ros2", "service", "call", f"{namespace.rstrip('/')}/laser/arm", "std_srvs/srv/SetBool", "{data: true}")


@dataclass(frozen=True)
class NodeSpec:
    """A node.

    Parameters
    ----------
    name : of the node and of its executable.
    module : has its class, and a ``main`` that runs it; its package holds the executable.
    factory : name of its class in that module.
    """

    name: str
    module: str
    factory: str

    @property
    def package(self) -> str:
        """The ROS package that holds its executable."""
        return self.module.partition(".")[0]

    def load(self) -> Callable[..., LceNode]:
        """The class of the node; its module is imported only now."""
        return cast("Callable[..., LceNode]", getattr(importlib.import_module(self.module), self.factory))

    @property
    def command(self) -> list[str]:
        """Command line that runs the node as a process of its own, which imports nothing from the current folder."""
        return [*SIGINT_BLOCKED, sys.executable, "-P", "-m", "lce_ros.executable", self.module]


PLAYER: Final = NodeSpec("experiment_player", "lce_experiment.nodes.experiment_player_node", "ExperimentPlayer")
TARGET_PLAYER: Final = NodeSpec("target_player", "lce_experiment.nodes.target_player_node", "TargetPlayer")
RECORDER: Final = NodeSpec("recorder", "lce_experiment.nodes.recorder_node", "Recorder")

LASER: Final = NodeSpec("laser", "lce_drivers.laser.laser_node", "Laser")
SIMULATOR: Final = NodeSpec("simulator", "lce_drivers.simulation.simulator_node", "Simulator")
SENSORS: Final = (
    NodeSpec("thermal_camera", "lce_drivers.camera.thermal_camera_node", "ThermalCamera"),
    NodeSpec("distance_sensor", "lce_drivers.distance.distance_sensor_node", "DistanceSensor"),
)
"""One for each channel that is measured."""
BENCH: Final = (LASER, SIMULATOR, *SENSORS)
"""The bench: the laser, the strip and its sensors."""

FEEDFORWARD: Final = NodeSpec("feedforward", "lce_control.nodes.feedforward_node", "Feedforward")
OUTER: Final = NodeSpec("outer_controller", "lce_control.nodes.outer_controller_node", "OuterController")
INNER: Final = NodeSpec("inner_controller", "lce_control.nodes.inner_controller_node", "InnerController")
SINGLE: Final = NodeSpec("single_controller", "lce_control.nodes.single_controller_node", "SingleController")
MODEL: Final = NodeSpec("model_controller", "lce_control.nodes.model_controller_node", "ModelController")
CONTROLLERS: Final[Mapping[str, tuple[NodeSpec, ...]]] = {
    "double": (FEEDFORWARD, OUTER, INNER),
    "single": (FEEDFORWARD, SINGLE),
    "model": (MODEL,),
}
"""Nodes of each mode of control."""
TARGET_LISTENERS: Final = (OUTER, SINGLE, MODEL)
"""Controllers that subscribe to targets."""
MODEL_READERS: Final = (FEEDFORWARD, MODEL)
"""Controllers with the parameter model_file."""
