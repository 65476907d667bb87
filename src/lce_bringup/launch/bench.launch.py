# SPDX-License-Identifier: Apache-2.0
"""The bench without an experiment: laser and sensors, and the simulated strip unless plant:=hardware.

When one node ends, all end, with status 1 if one failed. They also end when the launch is killed.
"""

from launch import LaunchDescription
from launch.conditions import IfCondition
from launch.substitutions import AndSubstitution, EqualsSubstitution, LaunchConfiguration
from launch_ros.parameter_descriptions import ParameterValue

from lce_experiment.launching import FLAG, argument, bench_files, common_arguments, node, text
from lce_experiment.registry import LASER, SENSORS, SIMULATOR


def generate_launch_description() -> LaunchDescription:
    """Laser, sensors (thermal camera, distance sensor) and simulator, with config/PLANT.yaml over config/bench.yaml."""
    files = bench_files()
    seed = {"seed": ParameterValue(LaunchConfiguration("seed"), value_type=int)}
    autostart = {"autostart": ParameterValue(LaunchConfiguration("autostart"), value_type=bool)}
    strip = {"model_file": text(LaunchConfiguration("model"))}
    plant, ours = LaunchConfiguration("plant"), LaunchConfiguration("simulator")
    simulated = IfCondition(AndSubstitution(EqualsSubstitution(plant, "simulated"), ours))
    return LaunchDescription(
        [
            *common_arguments(),
            argument("model", "", "model file of the simulated strip; empty: the default model"),
            argument("simulator", "true", "false: a node of yours takes the place of the simulated strip", FLAG),
            argument("seed", "-1", "of the simulated sensors' noise; -1: a new one"),
            argument("autostart", "true", "laser and sensors activate themselves; false: by ros2 lifecycle set", FLAG),
            node(LASER, [*files, autostart]),
            *(node(sensor, [*files, autostart, seed]) for sensor in SENSORS),
            node(SIMULATOR, [*files, strip], simulated),
        ]
    )
