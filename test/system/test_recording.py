# SPDX-License-Identifier: Apache-2.0
"""The recorder as a process: nothing dropped, nothing lost to a kill -9, nothing overwritten."""

import resource
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import yaml
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from run_command import experiment, lce, read, started, until
from std_msgs.msg import Float64

from lce_data.bag.repair import repair
from lce_experiment.nodes.recorder_node import Recorder
from lce_experiment.registry import LASER
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone

RECORDER = "lce_experiment.nodes.recorder_node"
PUBLISHER = """
import sys
from lce_ros.node import LceNode, run
from std_msgs.msg import Float64

class Publisher(LceNode):
    def __init__(self):
        super().__init__("publisher")
        count = self.declare("count", 5, "topics")
        self.out = [self.advertise(Float64, f"topic{k}") for k in range(count)]
        self.number = 0
        self.every(0.01, self.tick)

    def tick(self):
        if all(out.get_subscription_count() for out in self.out):
            for out in self.out:
                out.publish(Float64(data=float(self.number)))
            self.number += 1

sys.exit(run(Publisher))
"""


def _start(graph: Graph, folder: Path, topics: int = 1, **parameters: str) -> "subprocess.Popen[str]":
    """A recorder of topic0, topic1, ... that is ready to record."""
    names = ", ".join(f"topic{k} std_msgs/msg/Float64" for k in range(topics))
    return graph.start(RECORDER, out=str(folder), topics=f"[{names}]", **parameters)


def _finish(process: "subprocess.Popen[str]") -> None:
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=10)
    assert process.returncode == 0, errors


def _size(folder: Path) -> int:
    file = folder / "recording.mcap"
    return file.stat().st_size if file.exists() else 0


def test_nothing_is_dropped_on_five_topics_at_100_hz(graph: Graph, tmp_path: Path) -> None:
    recorder = _start(graph, tmp_path / "bag", topics=5)
    publisher = graph.start("", code=PUBLISHER, count="5")
    until(lambda: _size(tmp_path / "bag") > 200_000, "6 s of recording")
    _finish(publisher)
    _finish(recorder)
    found = {topic: np.array([m.data for m in messages]) for topic, (_, messages) in read(tmp_path / "bag").items()}
    assert sorted(found) == [f"/lce/topic{k}" for k in range(5)]
    for topic, numbers in found.items():
        np.testing.assert_array_equal(np.diff(numbers), 1.0, err_msg=topic)
        assert numbers[-1] == found["/lce/topic0"][-1] and numbers.size > 500
    assert set(experiment(tmp_path / "bag")["lost"].values()) == {0}


def test_a_killed_recorder_loses_less_than_a_second(graph: Graph, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    recorder = _start(graph, bag)
    node = graph.probe()
    out = node.advertise(Float64, "topic0")
    graph.until(out.get_subscription_count)
    sent = 0

    def send() -> None:
        nonlocal sent
        sent += 1
        out.publish(Float64(data=float(sent)))

    node.every(0.01, send)
    graph.until(lambda: _size(bag) > 12_000 and sent % 10 == 7, what="recording")
    graph.kill(recorder)
    state = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]["custom_data"]
    assert state["lce_state"] == "recording" and state["software.lce"]
    done = lce("repair", str(bag))
    assert done.returncode == 0 and "recording.mcap.truncated" in done.stdout, done.stderr
    numbers = np.array([m.data for m in read(bag)["/lce/topic0"][1]])
    np.testing.assert_array_equal(np.diff(numbers), 1.0)
    assert sent - numbers[-1] < 100 and numbers.size > 50, "100 messages are a second"
    assert repair(bag).original is None


def test_times_are_those_of_the_source(graph: Graph, tmp_path: Path) -> None:
    from mcap.reader import make_reader

    recorder = _start(graph, tmp_path / "bag")
    out = graph.probe().advertise(Float64, "topic0")
    graph.until(out.get_subscription_count)
    clock = Clock(clock_type=ClockType.SYSTEM_TIME)
    before = clock.now().nanoseconds
    for k in range(10):
        out.publish(Float64(data=float(k)))
    after = clock.now().nanoseconds
    until(lambda: _size(tmp_path / "bag") > 1_000, "flush")
    _finish(recorder)
    with (tmp_path / "bag" / "recording.mcap").open("rb") as file:
        messages = [message for _, _, message in make_reader(file).iter_messages()]
    assert len(messages) == 10
    assert all(before <= m.publish_time == m.log_time <= after for m in messages)


def test_a_recorder_that_stalls_shifts_and_loses_nothing(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.add(Recorder, out=str(tmp_path / "bag"), topics=["topic0 std_msgs/msg/Float64"])
    publisher = graph.start("", code=PUBLISHER, count="1")
    graph.until(lambda: recorder.received["/lce/topic0"] > 10, what="messages")
    began_s = time.monotonic()
    until(lambda: time.monotonic() > began_s + 3.0, "the end of the stall")  # nobody spins the recorder
    graph.until(lambda: recorder.received["/lce/topic0"] > 320, what="what waited in the queue")
    _finish(publisher)
    recorder.close()
    time_s, messages = read(tmp_path / "bag")["/lce/topic0"]
    np.testing.assert_array_equal(np.diff([m.data for m in messages]), 1.0)
    due_s = np.arange(time_s.size) * 0.01
    off_s = time_s - due_s - np.median(time_s - due_s)
    assert np.abs(off_s).max() < 0.1, "the publisher's own lateness"
    assert experiment(tmp_path / "bag")["lost"] == {"/lce/topic0": 0}


def test_what_a_stopped_recorder_loses_is_counted(graph: Graph, tmp_path: Path) -> None:
    bag, topics = tmp_path / "bag", 8
    recorder = _start(graph, bag, topics)
    publisher = graph.start("", code=PUBLISHER, count=str(topics))
    until(lambda: _size(bag) > 20_000, "recording")

    def lost() -> int:
        return sum(experiment(bag).get("lost", {}).values())

    for _ in range(3):  # stopped while it holds a lock of shared memory, it holds up the publisher, and nothing is lost
        recorder.send_signal(signal.SIGSTOP)
        graph.spin_for(3.0)
        recorder.send_signal(signal.SIGCONT)
        with suppress(AssertionError):
            until(lost, "the number of the lost, while it records", 10.0)
            break
    assert lost()
    _finish(publisher)
    _finish(recorder)
    for topic, (_, messages) in read(bag).items():
        missing = int(np.sum(np.diff([m.data for m in messages]) - 1.0))
        assert experiment(bag)["lost"][topic] == missing


def test_what_two_publishers_of_a_topic_lose_is_not_counted(graph: Graph, tmp_path: Path) -> None:
    """Each numbers its own messages, and nobody says whose number it is."""
    recorder = graph.add(Recorder, out=str(tmp_path / "bag"), topics=["topic0 std_msgs/msg/Float64"])
    first, second = (graph.probe(name).advertise(Float64, "topic0") for name in ("first", "second"))
    graph.until(lambda: first.get_subscription_count() and second.get_subscription_count())
    for number in range(10):
        for out in (first, second):
            out.publish(Float64(data=float(number)))
    graph.until(lambda: recorder.received["/lce/topic0"] == 20, what="the messages")
    recorder.close()
    assert len(read(tmp_path / "bag")["/lce/topic0"][1]) == 20
    assert experiment(tmp_path / "bag")["lost"] == {}


def test_a_recorder_that_is_stopped_with_the_laser_records_its_last_zero(graph: Graph, tmp_path: Path) -> None:
    """As by Ctrl-C in the terminal of a launch."""
    bag = tmp_path / "bag"
    recorder = graph.start(RECORDER, out=str(bag))
    laser = graph.start(LASER.module, temperature_required="false")
    probe = graph.probe()
    commands = probe.advertise(Float64, "laser/power_command")
    probe.every(0.01, lambda: commands.publish(Float64(data=1.0)))
    light = graph.collect(Float64, "laser/power", probe)
    graph.until(lambda: light.data[-1:] == [1.0] and _size(bag) > 10_000, 30.0, "light in the recording")
    recorder.send_signal(signal.SIGINT)
    graph.spin_for(0.3)  # the laser is the later of the two
    laser.send_signal(signal.SIGINT)
    _, errors = recorder.communicate(timeout=10)
    assert recorder.returncode == 0, errors
    power_w = [m.data for m in read(bag)["/lce/laser/power"][1]]
    assert max(power_w) == 1.0 and power_w[-1] == 0.0


def test_a_full_disk_ends_a_run_in_the_dark_with_one_line(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    with started("run", "hold:power=1.0,hold=60,rest=0", "--out", str(bag)) as run:
        (recorder,) = until(lambda: run.processes(RECORDER), "the recorder")
        until(lambda: _size(bag) > 200_000, "a recording")
        resource.prlimit(recorder, resource.RLIMIT_FSIZE, (300_000, 300_000))  # files of this process grow no more
        _, errors = run.process.communicate(timeout=30)
        assert run.process.returncode == 1 and run.processes() == []
    assert "Traceback" not in errors
    said = errors.strip().splitlines()[-1]
    assert said.startswith(
        f"lce: recorder ended early (status 1): {bag}/recording.mcap: cannot be written (File too large)"
    )
    assert experiment(bag)["outcome"] == "failed"
    done = lce("repair", str(bag))
    assert done.returncode == 0, done.stderr
    time_s, messages = read(bag)["/lce/laser/power"]
    assert messages[-1].data == 1.0 and time_s[-1] - time_s[0] > 1.0


@pytest.mark.parametrize("durability", ["transient_local", "volatile"])
def test_a_target_of_any_durability_is_recorded_once_with_its_publishers_quality_of_service(
    graph: Graph, tmp_path: Path, durability: str
) -> None:
    latched = durability == "transient_local"
    recorder = graph.start(RECORDER, out=str(tmp_path / "bag"))
    out = graph.probe().advertise(Float64, "target_displacement", latched=latched)
    graph.until(lambda: latched or out.get_subscription_count(), what="the recorder")
    out.publish(Float64(data=0.001))
    file = tmp_path / "bag" / "recording.mcap"
    until(lambda: file.exists() and b"/lce/target_displacement" in file.read_bytes(), "the latched message")
    _finish(recorder)
    assert [m.data for m in read(tmp_path / "bag")["/lce/target_displacement"][1]] == [0.001]
    topics = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    about = {t["topic_metadata"]["name"]: t["topic_metadata"] for t in topics["topics_with_message_count"]}
    profile = about["/lce/target_displacement"]["offered_qos_profiles"][0]
    assert (profile["durability"], profile["reliability"]) == (durability, "reliable")


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"topics": "[nothing]"}, "topic 'nothing' has no type here"),
        ({"topics": "[x std_msgs/msg/Nothing]"}, "std_msgs/msg/Nothing"),
        ({"experiment": "'[1]'"}, "not a JSON object"),
        ({"flush_period_s": "3.0"}, "flush_period_s"),
    ],
)
def test_a_bad_parameter_is_one_line_and_nothing_is_written(
    graph: Graph, tmp_path: Path, parameters: dict[str, str], said: str
) -> None:
    recorder = graph.start(RECORDER, out=str(tmp_path / "bag"), **parameters)
    _, errors = recorder.communicate(timeout=10)
    assert recorder.returncode == 1
    assert said in errors and errors.strip().count("\n") == 0
    assert list(tmp_path.iterdir()) == []


def test_an_existing_folder_is_left_alone(graph: Graph, tmp_path: Path) -> None:
    recorder = graph.start(RECORDER, out=str(tmp_path))
    _, errors = recorder.communicate(timeout=10)
    assert recorder.returncode == 1 and "exists already" in errors
    assert list(tmp_path.iterdir()) == []
