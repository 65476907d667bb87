# SPDX-License-Identifier: Apache-2.0
"""A bag of the bench, played back against the controllers, gives the commands that were recorded.

The player is this file's own: rosbag2 is not among the wheels. It publishes with the QoS that metadata.yaml names, as
``ros2 bag play --clock`` does.
"""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.highlevel import AnyReader
from run_command import lce, values
from std_msgs.msg import Float64

from lce_experiment.registry import CONTROLLERS
from lce_ros.node import CountingPublisher, LceNode
from lce_ros.testing import Graph

PLAYED = ("/lce/temperature", "/lce/displacement", "/lce/target_displacement")
CONFIG = Path(__file__).resolve().parents[2] / "src" / "lce_bringup" / "config"
TICK_NS = 10_000_000


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three seconds of position control."""
    folder: Path = tmp_path_factory.mktemp("bag") / "control"
    done = lce("control", "0.5", "--fast", "--hold", "3", "--seed", "1", "--out", str(folder))
    assert done.returncode == 0, done.stderr
    return folder


def offers(bag: Path) -> dict[str, tuple[str, QoSProfile]]:
    """Type and QoS of each topic by metadata.yaml."""
    information = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    found = {}
    for topic in (entry["topic_metadata"] for entry in information["topics_with_message_count"]):
        [offer] = topic["offered_qos_profiles"]
        profile = QoSProfile(
            depth=max(offer["depth"], 1),
            reliability=ReliabilityPolicy[offer["reliability"].upper()],
            durability=DurabilityPolicy[offer["durability"].upper()],
        )
        found[topic["name"]] = (topic["type"], profile)
    return found


def message_class(name: str) -> Any:
    package, _, message = name.split("/")
    return getattr(import_module(f"{package}.msg"), message)


def by_tick(bag: Path) -> Iterator[tuple[int, list[tuple[str, bytes]]]]:
    """The messages to be played, tick by tick: nanoseconds, topics and serialized messages."""
    with AnyReader([bag]) as reader:
        connections = [c for c in reader.connections if c.topic in PLAYED]
        messages = [(t, c.topic, data) for c, t, data in reader.messages(connections)]
        first, last = messages[0][0] // TICK_NS, messages[-1][0] // TICK_NS
    for tick in range(first, last + 1):
        yield tick * TICK_NS, [(topic, data) for t, topic, data in messages if t // TICK_NS == tick]


def player(graph: Graph, bag: Path) -> tuple[LceNode, dict[str, CountingPublisher]]:
    node = graph.probe("bag_player", sim_time=True)
    publishers = {}
    for topic, (kind, profile) in offers(bag).items():
        if topic in PLAYED:
            publisher = node.create_publisher(message_class(kind), topic, profile, publisher_class=CountingPublisher)
            publisher.counts, publisher.counted_as = node.published, topic
            node.published.setdefault(topic, 0)
            publishers[topic] = publisher
    return node, publishers


def controllers(graph: Graph) -> None:
    """The cascade, as `lce control` sets it up."""
    content = yaml.safe_load((CONFIG / "control.yaml").read_text())
    content["/**/feedforward"]["ros__parameters"]["model_file"] = str(CONFIG / "models" / "strip.yaml")
    for spec in CONTROLLERS["double"]:
        graph.add(spec.load(), sim_time=True, **content[f"/**/{spec.name}"]["ros__parameters"])


@pytest.mark.alone
def test_played_back_a_bag_makes_the_controllers_do_what_they_did(graph: Graph, bag: Path) -> None:
    controllers(graph)
    node, publishers = player(graph, bag)
    commands = graph.collect(Float64, "laser/power_command", node)
    for nanoseconds, messages in by_tick(bag):
        graph.time_s = (nanoseconds - TICK_NS) * 1e-9
        graph.lockstep(1)
        for topic, data in messages:
            publishers[topic].publish(data)
        graph.until(graph.at_rest)
    _, theirs = values(bag, "/lce/laser/power_command")
    ours = np.array(commands.data)
    assert ours.size >= theirs.size - 1 > 300 and ours.max() > 1.0
    np.testing.assert_allclose(ours, theirs[: ours.size], atol=1e-9)  # the very last one is the zero of the end


def test_a_bag_names_the_qos_with_which_it_is_played(bag: Path) -> None:
    """Played with them, a target reaches controllers that come later."""
    qualities = {topic: (qos.reliability.name, qos.durability.name) for topic, (_, qos) in offers(bag).items()}
    assert qualities.pop("/lce/target_displacement") == ("RELIABLE", "TRANSIENT_LOCAL")
    assert set(qualities.values()) == {("RELIABLE", "VOLATILE")}
