# SPDX-License-Identifier: Apache-2.0
"""Position control: the bench and the controllers of a mode. Targets [m] are published on target_displacement.

When one node ends, all end.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import EqualsSubstitution, LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare


def generate_launch_description() -> LaunchDescription:
    """Arguments of bench.launch.py, and mode and gains."""
    share = FindPackageShare("lce_bringup")
    namespace, mode, gains = (LaunchConfiguration(name) for name in ("namespace", "mode", "gains"))
    own = PathJoinSubstitution([share, "config", "control.yaml"])
    files = [ParameterFile(own), ParameterFile(gains)]
    model = {"model_file": ParameterValue(LaunchConfiguration("model"), value_type=str)}
    double, single, by_model = (IfCondition(EqualsSubstitution(mode, name)) for name in ("double", "single", "model"))
    end = Shutdown(reason="a controller has ended")
    enclaves = PythonExpression(["'/' + '", namespace, "'.strip('/')"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("plant", default_value="simulated", choices=["simulated", "hardware"]),
            DeclareLaunchArgument("namespace", default_value="lce"),
            DeclareLaunchArgument(
                "model",
                default_value=PathJoinSubstitution([share, "config", "models", "strip.yaml"]),
                description="model file of controller and simulated strip",
            ),
            DeclareLaunchArgument("mode", default_value="double", choices=["double", "single", "model"]),
            DeclareLaunchArgument("gains", default_value=own, description="parameter file over control.yaml"),
            IncludeLaunchDescription(PathJoinSubstitution([share, "launch", "bench.launch.py"])),
            Node(
                package="lce_control",
                executable="feedforward",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/feedforward"]],
                parameters=[*files, model],
                on_exit=end,
            ),
            Node(
                package="lce_control",
                executable="outer_controller",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/outer_controller"]],
                parameters=files,
                condition=double,
                on_exit=end,
            ),
            Node(
                package="lce_control",
                executable="inner_controller",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/inner_controller"]],
                parameters=files,
                condition=double,
                on_exit=end,
            ),
            Node(
                package="lce_control",
                executable="single_controller",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/single_controller"]],
                parameters=files,
                condition=single,
                on_exit=end,
            ),
            Node(
                package="lce_control",
                executable="model_controller",
                namespace=namespace,
                ros_arguments=["--enclave", [enclaves, "/model_controller"]],
                parameters=[*files, model],
                condition=by_model,
                on_exit=end,
            ),
        ]
    )
