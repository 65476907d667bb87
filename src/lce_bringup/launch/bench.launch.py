# SPDX-License-Identifier: Apache-2.0
"""The bench without an experiment: laser and sensors, and the simulated strip unless plant:=hardware.

When one node ends, all end. They also end when the launch is killed.
"""

import os

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import EqualsSubstitution, LaunchConfiguration, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare

from lce_experiment.registry import SENSORS
from lce_ros.parent import PARENT

DISCOVERY_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def generate_launch_description() -> LaunchDescription:
    """Laser, sensors (thermal camera, distance sensor) and simulator, with config/PLANT.yaml over config/bench.yaml."""
    plant = LaunchConfiguration("plant")
    namespace = LaunchConfiguration("namespace")
    share = FindPackageShare("lce_bringup")
    files = [ParameterFile([share, "/config/", name, ".yaml"]) for name in ("bench", plant)]
    seed = {"seed": ParameterValue(LaunchConfiguration("seed"), value_type=int)}
    strip = {"model_file": ParameterValue(LaunchConfiguration("model"), value_type=str)}
    end = Shutdown(reason="a node of the bench has ended")
    enclaves = PythonExpression(["'/' + '", namespace, "'.strip('/')"])
    return LaunchDescription(
        [
            SetEnvironmentVariable(DISCOVERY_RANGE, os.environ.get(DISCOVERY_RANGE) or "LOCALHOST"),
            SetEnvironmentVariable(PARENT, os.environ.get(PARENT) or str(os.getpid())),
            DeclareLaunchArgument("plant", default_value="simulated", choices=["simulated", "hardware"]),
            DeclareLaunchArgument("namespace", default_value="lce"),
            DeclareLaunchArgument("model", default_value="", description="model file of the simulated strip"),
            DeclareLaunchArgument("seed", default_value="-1", description="sensor noise; -1: a new one"),
            Node(
                package="lce_drivers",
                executable="laser",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/laser"]],
                parameters=files,
                on_exit=end,
            ),
            *(
                Node(
                    package=sensor.package,
                    executable=sensor.name,
                    namespace=namespace,
                    ros_arguments=["--enclave", [enclaves, f"/{sensor.name}"]],
                    parameters=[*files, seed],
                    on_exit=end,
                )
                for sensor in SENSORS
            ),
            Node(
                package="lce_drivers",
                executable="simulator",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/simulator"]],
                parameters=[*files, strip],
                condition=IfCondition(EqualsSubstitution(plant, "simulated")),
                on_exit=end,
            ),
        ]
    )
