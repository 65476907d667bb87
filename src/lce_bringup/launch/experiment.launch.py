# SPDX-License-Identifier: Apache-2.0
"""An experiment: the bench, the recorder and the player. When the player ends, all end and the bag is finished."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Arguments of bench.launch.py, and protocol, record, out."""
    share = FindPackageShare("lce_bringup")
    protocol, record, plant = (LaunchConfiguration(name) for name in ("protocol", "record", "plant"))
    namespace = LaunchConfiguration("namespace")
    files = [ParameterFile([share, "/config/", name, ".yaml"]) for name in ("bench", plant)]
    about = ['{"mode": "launch", "protocol": "', protocol, '", "plant": "', plant, '"}']
    enclaves = PythonExpression(["'/' + '", namespace, "'.strip('/')"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("plant", default_value="simulated", choices=["simulated", "hardware"]),
            DeclareLaunchArgument("namespace", default_value="lce"),
            DeclareLaunchArgument("protocol", default_value="pulse", description="see lce run --help"),
            DeclareLaunchArgument("record", default_value="true", choices=["true", "false"]),
            DeclareLaunchArgument("out", default_value="", description="new folder; empty: runs/DATE-TIME"),
            IncludeLaunchDescription(PathJoinSubstitution([share, "launch", "bench.launch.py"])),
            Node(
                package="lce_experiment",
                executable="recorder",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/recorder"]],
                parameters=[
                    *files,
                    {
                        "out": ParameterValue(LaunchConfiguration("out"), value_type=str),
                        "experiment": ParameterValue(about, value_type=str),
                    },
                ],
                condition=IfCondition(record),
                on_exit=Shutdown(reason="the recorder has ended"),
            ),
            Node(
                package="lce_experiment",
                executable="experiment_player",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/experiment_player"]],
                parameters=[
                    *files,
                    {
                        "protocol": ParameterValue(protocol, value_type=str),
                        "wait_for_recorder": ParameterValue(record, value_type=bool),
                    },
                ],
                on_exit=Shutdown(reason="the experiment is over"),
            ),
        ]
    )
