# SPDX-License-Identifier: Apache-2.0
"""/rosout tells the story of a run: what each node does, what is missing, and how it ends."""

from collections import defaultdict
from pathlib import Path

import pytest
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile
from run_command import started

from lce_ros.testing import Graph

pytestmark = pytest.mark.alone


def test_rosout_tells_the_story_of_a_run(graph: Graph, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", str(graph.domain))
    said: dict[str, list[str]] = defaultdict(list)
    all_lines = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    graph.probe().create_subscription(Log, "/rosout", lambda line: said[line.name].append(line.msg), all_lines)
    with started("run", "hold:power=1,hold=1,rest=1", "--out", str(tmp_path / "bag")) as run:
        graph.until(lambda: run.process.poll() is not None, 60.0, "the end of the run")
        assert run.process.returncode == 0
    graph.until(lambda: "complete" in said["lce.experiment_player"], what="the last line of the player")
    player, recorder = said["lce.experiment_player"], said["lce.recorder"]
    assert player[0].startswith("hold:power=1,hold=1,rest=1: at most 1 W; 3 s with the dark, 100 Hz; waiting for ")
    assert player[-2:] == ["playing", "complete"]
    assert recorder[0].endswith(f" topics into {tmp_path / 'bag'}, to the disk every 0.25 s")
    assert recorder[-1].endswith(f" messages in {tmp_path / 'bag'}, 0 lost")
    assert said["lce.simulator"][-1] == "running"
