# SPDX-License-Identifier: Apache-2.0
"""An experiment: the bench, the recorder and the player. When the player ends, all end and the bag is finished.

When another node ends, all end, too. The status is 1 if a node failed; experiment.yaml beside the bag says whether the
run is complete, interrupted or failed.
"""

from launch import LaunchDescription
from launch.substitutions import LaunchConfiguration
from launch_ros.parameter_descriptions import ParameterValue

from lce_experiment.launching import (
    argument,
    bench_files,
    common_arguments,
    include,
    node,
    recorder,
    recording_arguments,
    text,
)
from lce_experiment.registry import PLAYER


def generate_launch_description() -> LaunchDescription:
    """Arguments of bench.launch.py, and protocol, record, out."""
    protocol, record, plant = (LaunchConfiguration(name) for name in ("protocol", "record", "plant"))
    played = {"protocol": text(protocol), "wait_for_recorder": ParameterValue(record, value_type=bool)}
    return LaunchDescription(
        [
            *common_arguments(),
            *recording_arguments("true"),
            argument("protocol", "pulse", "what the laser does: a protocol of lce run --help, or a wave.csv"),
            include("bench.launch.py"),
            recorder([protocol], plant),
            node(PLAYER, [*bench_files(), played], ends_well=True),
        ]
    )
