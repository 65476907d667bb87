# SPDX-License-Identifier: Apache-2.0
"""The bench without an experiment: laser and sensors, and the simulated strip unless plant:=hardware."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import EqualsSubstitution, LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Laser, thermal camera, distance sensor and simulator, with config/PLANT.yaml over config/bench.yaml."""
    plant = LaunchConfiguration("plant")
    namespace = LaunchConfiguration("namespace")
    config = PathJoinSubstitution([FindPackageShare("lce_bringup"), "config"])
    files = [
        PathJoinSubstitution([config, "bench.yaml"]),
        PathJoinSubstitution([config, [plant, ".yaml"]]),
    ]
    seed = {"seed": ParameterValue(LaunchConfiguration("seed"), value_type=int)}
    strip = {"model_file": ParameterValue(LaunchConfiguration("model"), value_type=str)}
    return LaunchDescription(
        [
            DeclareLaunchArgument("plant", default_value="simulated", choices=["simulated", "hardware"]),
            DeclareLaunchArgument("namespace", default_value="lce"),
            DeclareLaunchArgument("model", default_value="", description="model file of the simulated strip"),
            DeclareLaunchArgument("seed", default_value="-1", description="sensor noise; -1: a new one"),
            Node(package="lce_drivers", executable="laser", namespace=namespace, parameters=files),
            Node(
                package="lce_drivers",
                executable="thermal_camera",
                namespace=namespace,
                parameters=[*files, seed],
            ),
            Node(
                package="lce_drivers",
                executable="distance_sensor",
                namespace=namespace,
                parameters=[*files, seed],
            ),
            Node(
                package="lce_drivers",
                executable="simulator",
                namespace=namespace,
                parameters=[*files, strip],
                condition=IfCondition(EqualsSubstitution(plant, "simulated")),
            ),
        ]
    )
