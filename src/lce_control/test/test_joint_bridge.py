# SPDX-License-Identifier: Apache-2.0
import math

import pytest
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from lce_control.nodes.joint_bridge_node import JointBridge
from lce_data.topics import TARGET
from lce_interfaces.msg import Float64Stamped
from lce_ros.conversions import to_stamp
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone


def test_a_displacement_is_the_state_of_the_joint_at_its_time_of_measurement(graph: Graph) -> None:
    states: list[JointState] = []
    probe = graph.probe("ros2_control")
    probe.create_subscription(JointState, "joint_states", states.append, qos_profile_sensor_data)
    sensor = probe.advertise(Float64Stamped, "displacement_stamped")
    graph.add(JointBridge, joint="left_strip")
    graph.until(lambda: sensor.get_subscription_count() and probe.count_publishers("joint_states"), what="the bridge")
    measured = Float64Stamped(value=0.0012)
    measured.header.stamp = to_stamp(12.5)
    sensor.publish(measured)
    graph.until(lambda: states, what="a joint state")
    assert (states[0].name, list(states[0].position)) == (["left_strip"], [0.0012])
    assert states[0].header.stamp == to_stamp(12.5)


def test_a_command_is_a_target_once_and_nonsense_is_none(graph: Graph) -> None:
    targets: list[float] = []
    probe = graph.probe("ros2_control")
    commands = probe.create_publisher(JointState, "joint_commands", QoSProfile(depth=1))
    probe.listen(Float64, TARGET, lambda message: targets.append(message.data), latched=True)
    graph.add(JointBridge)
    graph.until(commands.get_subscription_count, what="the bridge")
    for names, positions in (
        (["strip"], [math.nan]),
        (["strip"], []),
        (["gripper"], [0.3]),
        (["gripper", "strip"], [0.3, 0.001]),
        (["strip"], [0.001]),
        (["strip"], [0.0]),
    ):
        commands.publish(JointState(name=names, position=positions))
        graph.spin_for(0.05)
    graph.until(lambda: len(targets) == 2, what="two targets")
    assert targets == [0.001, 0.0]
