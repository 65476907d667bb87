# SPDX-License-Identifier: Apache-2.0
"""An experiment under `ros2 launch`, stopped while there is light: every topic is there, and every node ends in order.

launch_test test/system/launch_tests/stopped_in_light.py
"""

import tempfile
import unittest
from pathlib import Path

import launch_testing
import rclpy
import yaml
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch_testing.actions import ReadyToTest
from launch_testing.asserts import assertExitCodes
from launch_testing_ros import WaitForTopics
from rclpy.node import Node
from rclpy.task import Future
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

NAMESPACE = "left_arm"
POWER_W = 1.5
TOPICS = [
    ("laser/power_command", Float64),
    ("laser/power", Float64),
    ("temperature", Temperature),
    ("displacement", Float64),
]
SHARE = Path(get_package_share_directory("lce_bringup"))


def generate_test_description() -> tuple[LaunchDescription, dict[str, object]]:
    """The launch file of an experiment of ten minutes; the folder of its recording is handed to the tests."""
    bag = Path(tempfile.mkdtemp()) / "bag"
    arguments = {"protocol": f"hold:power={POWER_W},hold=600", "namespace": NAMESPACE, "out": str(bag), "seed": "1"}
    experiment = IncludeLaunchDescription(
        str(SHARE / "launch" / "experiment.launch.py"), launch_arguments=arguments.items()
    )
    return LaunchDescription([experiment, ReadyToTest()]), {"bag": bag}


class WhileThereIsLight(unittest.TestCase):
    """When these tests are over, launch_testing stops the launch as Ctrl-C does."""

    def test_the_laser_follows_the_protocol(self) -> None:
        rclpy.init()
        node = Node("light_watch")
        lit = Future()
        node.create_subscription(
            Float64, f"/{NAMESPACE}/laser/power", lambda power: power.data == POWER_W and lit.set_result(True), 10
        )
        rclpy.spin_until_future_complete(node, lit, timeout_sec=60.0)
        node.destroy_node()
        rclpy.shutdown()
        assert lit.done(), f"no {POWER_W} W on laser/power within 60 s"

    def test_every_topic_has_messages(self) -> None:
        topics = [(f"/{NAMESPACE}/{name}", message) for name, message in TOPICS]
        with WaitForTopics(topics, timeout=60.0):
            pass


@launch_testing.post_shutdown_test()
class AfterTheStop(unittest.TestCase):
    def test_every_node_ended_in_order(self, proc_info: launch_testing.ProcInfoHandler) -> None:
        assertExitCodes(proc_info)

    def test_no_node_left_a_traceback(self, proc_output: launch_testing.IoHandler) -> None:
        said = "".join(line.text.decode() for line in proc_output)
        assert "Traceback" not in said, said

    def test_the_recording_is_finished_and_ends_dark(self, bag: Path) -> None:
        with AnyReader([bag]) as reader:
            connections = [c for c in reader.connections if c.topic == f"/{NAMESPACE}/laser/power"]
            powers = [
                reader.deserialize(data, connection.msgtype).data
                for connection, _, data in reader.messages(connections)
            ]
        assert max(powers) == POWER_W and powers[-1] == 0.0
        about = yaml.safe_load((bag / "experiment.yaml").read_text(encoding="utf-8"))
        assert about["outcome"] == "interrupted"
