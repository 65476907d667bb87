# SPDX-License-Identifier: Apache-2.0
"""The executables of this package: each imports its node when it is called, so it can be stopped at once."""

from lce_ros.executable import Executable

feedforward = Executable("lce_control.nodes.feedforward_node")
inner_controller = Executable("lce_control.nodes.inner_controller_node")
outer_controller = Executable("lce_control.nodes.outer_controller_node")
joint_bridge = Executable("lce_control.nodes.joint_bridge_node")
model_controller = Executable("lce_control.nodes.model_controller_node")
single_controller = Executable("lce_control.nodes.single_controller_node")
