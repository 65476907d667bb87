# SPDX-License-Identifier: Apache-2.0
"""The topics of the bench are those of the contract: names, types, units, rates, stamps."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from run_command import lce, read
from std_msgs.msg import Bool, Float64

from lce_ros.health import Level, node_of
from lce_ros.testing import Graph

CONTRACT = {
    "/lce/laser/power_command": ("std_msgs/msg/Float64", 100.0),
    "/lce/laser/power_command_stamped": ("lce_interfaces/msg/Float64Stamped", 100.0),
    "/lce/laser/power_stamped": ("lce_interfaces/msg/Float64Stamped", 100.0),
    "/lce/displacement_stamped": ("lce_interfaces/msg/Float64Stamped", 100.0),
    "/lce/laser/power": ("std_msgs/msg/Float64", 100.0),
    "/lce/temperature": ("sensor_msgs/msg/Temperature", 10.0),
    "/lce/displacement": ("std_msgs/msg/Float64", 100.0),
    "/lce/sim/temperature": ("sensor_msgs/msg/Temperature", 100.0),
    "/lce/sim/displacement": ("std_msgs/msg/Float64", 100.0),
    "/diagnostics": ("diagnostic_msgs/msg/DiagnosticArray", 6.0),
}
"""Type and rate in Hz; six nodes diagnose themselves once a second."""


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pulse, recorded through the graph."""
    folder = tmp_path_factory.mktemp("topics") / "bag"
    done = lce("run", "pulse:th=20,rest=20", "--fast", "--seed", "1", "--out", str(folder))
    assert done.returncode == 0, done.stderr
    return folder


def test_names_types_and_rates(bag: Path) -> None:
    with AnyReader([bag]) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == {k: v[0] for k, v in CONTRACT.items()}
        for connection in reader.connections:
            rate = CONTRACT[connection.topic][1]
            assert connection.msgcount == pytest.approx(rate * reader.duration / 1e9, rel=0.03), connection.topic


def test_units_and_signs(bag: Path) -> None:
    found = read(bag)
    temperature = np.array([m.temperature for m in found["/lce/temperature"][1]])
    displacement = np.array([m.data for m in found["/lce/displacement"][1]])
    assert temperature[0] == pytest.approx(28.0, abs=0.5)
    assert 45 < temperature.max() < 120
    assert 2e-4 < displacement.max() < 5e-3, "contraction is positive, in metres"


def test_a_temperature_has_a_stamp_and_a_variance(bag: Path) -> None:
    messages = read(bag)["/lce/temperature"][1]
    stamps = np.array([m.header.stamp.sec + m.header.stamp.nanosec * 1e-9 for m in messages])
    np.testing.assert_allclose(np.diff(stamps)[1:], 0.1, atol=1e-6)
    assert all(m.variance == pytest.approx(0.06**2, rel=0.05) for m in messages)


def test_every_node_diagnoses_itself(bag: Path) -> None:
    names = {node_of(status.name) for message in read(bag)["/diagnostics"][1] for status in message.status}
    nodes = ("laser", "simulator", "thermal_camera", "distance_sensor", "experiment_player", "recorder")
    assert {f"/lce/{name}" for name in nodes} <= names


@pytest.mark.alone
def test_the_player_waits_for_an_armed_laser_then_plays_and_ends(graph: Graph) -> None:
    player = graph.start("lce_experiment.nodes.experiment_player_node", protocol="hold:power=1.0,hold=1,rest=0.5")
    node = graph.probe("someone_else")
    power = graph.collect(Float64, "laser/power_command", node)
    graph.until(lambda: node.count_publishers("laser/power_command"), what="the player")
    graph.spin_for(0.5)
    assert len(power) == 0
    laser = graph.probe("laser")
    laser.listen(Float64, "laser/power_command", lambda message: None)
    graph.spin_for(1.5)
    assert len(power) == 0, "a laser that is not armed"
    laser.advertise(Bool, "laser/armed", latched=True).publish(Bool(data=True))
    graph.until(lambda: player.poll() is not None, timeout_s=20, what="the end of the player")
    assert player.returncode == 0
    commands = np.array(power.data)
    assert set(commands) == {0.0, 1.0} and commands[0] == 0 and commands[-1] == 0
    assert np.sum(commands == 1.0) == pytest.approx(100, abs=15)


@pytest.mark.alone
def test_the_fault_that_a_laser_had_before_it_was_armed_again_does_not_end_the_player(graph: Graph) -> None:
    """The status of a second is the worst of it, so the first one that the player hears may tell of it."""
    laser = graph.probe("laser")
    laser.listen(Float64, "laser/power_command", lambda message: None)
    laser.advertise(Bool, "laser/armed", latched=True).publish(Bool(data=True))

    def recover() -> None:
        laser.report(Level.ERROR, "fault: no command")
        laser.report(Level.OK, "armed")

    laser.every(0.1, recover)
    player = graph.start("lce_experiment.nodes.experiment_player_node", protocol="hold:power=1.0,hold=2,rest=0.5")
    graph.until(lambda: player.poll() is not None, timeout_s=20, what="the end of the player")
    assert player.returncode == 0, player.communicate()


@pytest.mark.alone
def test_a_laser_that_is_disarmed_and_armed_again_ends_the_player(graph: Graph) -> None:
    laser = graph.probe("laser")
    power = graph.collect(Float64, "laser/power_command", laser)
    armed = laser.advertise(Bool, "laser/armed", latched=True)
    armed.publish(Bool(data=True))
    player = graph.start("lce_experiment.nodes.experiment_player_node", protocol="hold:power=1.0,hold=20,rest=0.5")
    graph.until(lambda: 1.0 in power.data, what="light")
    armed.publish(Bool(data=False))
    graph.spin_for(0.2)
    armed.publish(Bool(data=True))
    _, errors = player.communicate(timeout=15)
    assert player.returncode == 1 and "stopped: the laser was disarmed" in errors


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({}, "parameter protocol is empty"),
        ({"protocol": "puls"}, "unknown protocol 'puls'"),
        ({"protocol": "pulse", "patience_s": "0.3"}, "no laser after 0.3 s"),
        ({"protocol": "pulse", "arming_patience_s": "0.3"}, "nobody armed the laser within 0.3 s"),
    ],
)
def test_a_player_that_cannot_play_says_why(graph: Graph, parameters: dict[str, str], said: str) -> None:
    if "arming_patience_s" in parameters:
        graph.probe("laser").listen(Float64, "laser/power_command", lambda message: None)
    player = graph.start("lce_experiment.nodes.experiment_player_node", **parameters)
    _, errors = player.communicate(timeout=15)
    assert player.returncode == 1
    assert said in errors


def test_diagnostics_are_named_as_rep_107_has_it(bag: Path) -> None:
    """That is "NODE: WHAT", and the device that the node speaks to."""
    found = {s.name: s.hardware_id for m in read(bag)["/diagnostics"][1] for s in m.status}
    assert found == {
        "/lce/experiment_player: waveform": "none",
        "/lce/laser: output": "simulated",
        "/lce/simulator: strip": "simulated",
        "/lce/thermal_camera: temperature": "simulated",
        "/lce/distance_sensor: displacement": "simulated",
        "/lce/recorder: recording": "none",
    }
