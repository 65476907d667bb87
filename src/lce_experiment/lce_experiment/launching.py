# SPDX-License-Identifier: Apache-2.0
"""What the launch files of lce_bringup share: arguments, nodes, and the end of a launch.

A launch ends when one of its nodes ends. Its exit status is 1 if a node failed, and experiment.yaml tells the outcome.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from signal import SIGINT
from typing import Any, Final

from launch import Condition, LaunchContext, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, SetEnvironmentVariable, Shutdown
from launch.conditions import IfCondition
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare

from lce_data import experiment_file
from lce_experiment.plan import RUNS, new_folder
from lce_experiment.registry import RECORDER, SIGINT_BLOCKED, NodeSpec
from lce_ros.parent import PARENT

DISCOVERY_RANGE: Final = "ROS_AUTOMATIC_DISCOVERY_RANGE"
SHARE: Final = FindPackageShare("lce_bringup")
FLAG: Final = ["true", "false"]
LEVELS: Final = ["debug", "info", "warn", "error", "fatal"]
UNKNOWN: Final = 255
"""The status that asyncio makes up where it has missed that of a process, as can happen at Ctrl-C."""
OUTCOME, RECORDED = "outcome", "recorded"
"""Launch configurations in which a launch keeps how it ends: the outcome, and whether the recorder has ended."""


class NodeFailed(RuntimeError):
    """A node ended with an error; raised in a launch, it ends that launch with status 1."""


def argument(name: str, default: Any, description: str, choices: Sequence[str] | None = None) -> DeclareLaunchArgument:
    """An argument of a launch file: ``name:=value``."""
    return DeclareLaunchArgument(name, default_value=default, description=description, choices=choices)


def common_arguments() -> list[LaunchDescriptionEntity]:
    """The arguments of every launch file, and the environment of its nodes."""
    return [
        SetEnvironmentVariable(DISCOVERY_RANGE, os.environ.get(DISCOVERY_RANGE) or "LOCALHOST"),
        SetEnvironmentVariable(PARENT, os.environ.get(PARENT) or str(os.getpid())),
        argument("plant", "simulated", "the simulated strip, or the real bench", ["simulated", "hardware"]),
        argument("namespace", "lce", "namespace of all nodes: one for each actuator"),
        argument(
            "params_file",
            config(LaunchConfiguration("plant"), ".yaml"),
            "parameter file over bench.yaml and PLANT.yaml, such as your copy of hardware.yaml",
        ),
        argument("use_sim_time", "false", "the nodes' time is that of /clock; a real laser refuses it", FLAG),
        argument("log_level", "info", "of every node", LEVELS),
    ]


def recording_arguments(record: str) -> list[LaunchDescriptionEntity]:
    """The arguments of a launch file that can record; ``record`` is the default, true or false."""
    return [
        argument("record", record, "record a bag", FLAG),
        argument("out", str(new_folder(RUNS)), "new folder of the recording, by default named by the time"),
        argument("conditions", "{}", "JSON object: specimen, day, notes, strip_length_m, ambient_c, load_n"),
    ]


def config(*name: Any) -> list[Any]:
    """A file of the installed folder config."""
    return [SHARE, "/config/", *name]


def include(name: str) -> IncludeLaunchDescription:
    """Another launch file of lce_bringup, with the arguments of this one."""
    return IncludeLaunchDescription(PathJoinSubstitution([SHARE, "launch", name]))


def bench_files() -> list[ParameterFile]:
    """Parameter files of the bench, the last one on top."""
    plant = config(LaunchConfiguration("plant"), ".yaml")
    return [ParameterFile(file) for file in (config("bench.yaml"), plant, LaunchConfiguration("params_file"))]


def text(value: Any) -> ParameterValue:
    """A parameter that is text, even where it looks like a number."""
    return ParameterValue(value, value_type=str)


def node(
    spec: NodeSpec, parameters: Sequence[Any], condition: Condition | None = None, ends_well: bool = False
) -> Node:
    """A node as every launch file starts it; when it ends, the launch ends.

    Parameters
    ----------
    spec : the node.
    parameters : files and dictionaries, the last one on top.
    condition : the node is started only where it holds.
    ends_well : the experiment is complete when this node ends without an error.
    """
    namespace = LaunchConfiguration("namespace")
    enclave = [PythonExpression(["'/' + '", namespace, "'.strip('/')"]), f"/{spec.name}"]
    time = {"use_sim_time": ParameterValue(LaunchConfiguration("use_sim_time"), value_type=bool)}
    return Node(
        package=spec.package,
        executable=spec.name,
        exec_name=spec.name,
        namespace=namespace,
        parameters=[*parameters, time],
        ros_arguments=["--enclave", enclave, "--log-level", LaunchConfiguration("log_level")],
        prefix=[LaunchConfiguration("launch-prefix", default=""), f" {' '.join(SIGINT_BLOCKED)}"],
        condition=condition,
        on_exit=_end(spec, ends_well),
    )


def recorder(protocol: Sequence[Any], plant: Any) -> Node:
    """The recorder, with what experiment.yaml says of the protocol, the plant, its model, and the conditions."""
    about = [
        *('{"mode": "launch", "protocol": "', *protocol, '", "plant": "', plant),
        *('", "model": {"file": "', LaunchConfiguration("model")),
        *('"}, "conditions": ', LaunchConfiguration("conditions"), "}"),
    ]
    own = {"out": text(LaunchConfiguration("out")), "experiment": text(about)}
    return node(RECORDER, [*bench_files(), own], IfCondition(LaunchConfiguration("record")))


def _end(spec: NodeSpec, ends_well: bool) -> Callable[[ProcessExited, LaunchContext], Shutdown | None]:
    """What a launch does when a node has ended: end all others, and tell the outcome in the recording."""

    def ended(event: ProcessExited, context: LaunchContext) -> Shutdown | None:
        known, first = context.launch_configurations, not context.is_shutdown
        failed = event.returncode not in ((0, -SIGINT) if first else (0, -SIGINT, UNKNOWN))
        if failed:
            known[OUTCOME] = "failed"
        elif ends_well and first:
            known[OUTCOME] = "complete"
        if spec is RECORDER:
            known[RECORDED] = known["out"]
        if folder := known.get(RECORDED):
            _tell(Path(folder), known.get(OUTCOME, "interrupted"))
        if failed:
            raise NodeFailed(f"{event.process_name} ended with status {event.returncode}")
        return Shutdown(reason=f"{event.process_name} has ended") if first else None

    return ended


def _tell(folder: Path, outcome: str) -> None:
    """Write the outcome into a recording, if it had begun."""
    if (folder / experiment_file.FILE_NAME).exists():
        experiment_file.update(folder, outcome=outcome)
