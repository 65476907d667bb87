# SPDX-License-Identifier: Apache-2.0
"""The executables of this package: each imports its node when it is called, so it can be stopped at once."""

from lce_ros.executable import Executable

experiment_player = Executable("lce_experiment.nodes.experiment_player_node")
target_player = Executable("lce_experiment.nodes.target_player_node")
recorder = Executable("lce_experiment.nodes.recorder_node")
