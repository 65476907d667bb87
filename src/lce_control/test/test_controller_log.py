# SPDX-License-Identifier: Apache-2.0
"""A controller says at its start what it does, and later what it misses, once."""

import pytest
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64

from lce_control.nodes.inner_controller_node import InnerController
from lce_control.nodes.outer_controller_node import OuterController
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone
INFO, WARN = 20, 30


def test_the_log_of_a_cascade_without_its_feed_forward(graph: Graph) -> None:
    probe = graph.probe(sim_time=True)
    said: list[Log] = []
    probe.create_subscription(
        Log, "/rosout", said.append, QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    )
    displacement = probe.advertise(Float64, "displacement")
    target = probe.advertise(Float64, "target_displacement", latched=True)
    for controller in (InnerController, OuterController):
        graph.add(controller, sim_time=True)
    target.publish(Float64(data=1e-3))
    graph.lockstep(210, lambda: displacement.publish(Float64(data=1e-6 * graph.time_s)))
    lines = {(m.name, m.level, m.msg) for m in said}
    gains = "kp 0.05 W/K, ki 0.01 W/(K s), kd 0.001 W s/K"
    assert ("lce.inner_controller", INFO, f"100 Hz; at most 2 W; {gains}") in lines
    gains = "kp 39 K/m, ki 13 K/(m s), kd 2 K s/m"
    assert ("lce.outer_controller", INFO, f"100 Hz; setpoints from 0 to 110 °C; {gains}") in lines
    waits = "a target waits for the service inverse_temperature: no setpoint"
    assert [m.level for m in said if m.msg == waits] == [WARN]
    assert ("lce.inner_controller", INFO, "no setpoint: zero power") in lines
