# SPDX-License-Identifier: Apache-2.0
"""Position control: the bench and the controllers of a mode. Targets [m] are published on target_displacement.

When one node ends, all end, with status 1 if one failed.
"""

from launch import LaunchDescription
from launch.conditions import IfCondition
from launch.substitutions import EqualsSubstitution, LaunchConfiguration
from launch_ros.parameter_descriptions import ParameterFile

from lce_experiment.launching import (
    argument,
    common_arguments,
    config,
    include,
    node,
    recorder,
    recording_arguments,
    text,
)
from lce_experiment.registry import FEEDFORWARD, INNER, MODEL, OUTER, SINGLE


def generate_launch_description() -> LaunchDescription:
    """Arguments of bench.launch.py, and mode, gains, record, out."""
    mode, plant = LaunchConfiguration("mode"), LaunchConfiguration("plant")
    # The gains of lce tune have the power limit of its strip; that of the bench goes before it.
    layers = (
        config("control.yaml"),
        LaunchConfiguration("gains"),
        config(plant, ".yaml"),
        LaunchConfiguration("params_file"),
    )
    files = [ParameterFile(file) for file in layers]
    model = {"model_file": text(LaunchConfiguration("model"))}
    double, single, by_model = (IfCondition(EqualsSubstitution(mode, name)) for name in ("double", "single", "model"))
    return LaunchDescription(
        [
            *common_arguments(),
            *recording_arguments("false"),
            argument("model", config("models/strip.yaml"), "model file of controller and simulated strip"),
            argument("mode", "double", "controllers: cascade, one loop, or model", ["double", "single", "model"]),
            argument("gains", config("control.yaml"), "parameter file over control.yaml, as lce tune writes it"),
            include("bench.launch.py"),
            recorder(["control ", mode], plant),
            node(FEEDFORWARD, [*files, model]),
            node(OUTER, files, double),
            node(INNER, files, double),
            node(SINGLE, files, single),
            node(MODEL, [*files, model], by_model),
        ]
    )
