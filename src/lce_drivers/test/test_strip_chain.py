# SPDX-License-Identifier: Apache-2.0
"""laser → simulator → camera and distance sensor: what is measured is the model plus the noise."""

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64

from lce_drivers.camera.thermal_camera_node import ThermalCamera
from lce_drivers.distance.distance_sensor_node import DistanceSensor
from lce_drivers.laser.laser_node import Laser
from lce_drivers.simulation.simulator_node import Simulator
from lce_interfaces.msg import Float64Stamped
from lce_model import default_model, simulate
from lce_ros.conversions import from_stamp
from lce_ros.health import node_of
from lce_ros.testing import Graph, Received, open_graph

pytestmark = pytest.mark.alone


@dataclass
class Recording:
    power: Received
    temperature: Received
    displacement: Received
    true_temperature: Received
    true_displacement: Received


def record(graph: Graph, ticks: int, sim_time: bool = True, **parameters: Any) -> Recording:
    """Half a watt for the first half, 0.1 W for the second, through all four nodes."""
    graph.add(Laser, sim_time=sim_time)
    graph.add(Simulator, sim_time=sim_time)
    graph.add(ThermalCamera, sim_time=sim_time, **parameters)
    graph.add(DistanceSensor, sim_time=sim_time, **parameters)
    probe = graph.probe(sim_time=sim_time)
    commands = probe.advertise(Float64, "laser/power_command")
    topics = [(Float64, "laser/power"), (Temperature, "temperature"), (Float64, "displacement")]
    topics += [(Temperature, "sim/temperature"), (Float64, "sim/displacement")]
    received = [graph.collect(msg_type, topic, probe) for msg_type, topic in topics]
    graph.connect()
    count = 0

    def command() -> None:
        nonlocal count
        count += 1
        commands.publish(Float64(data=0.5 if count < ticks / 2 else 0.1))

    probe.every(0.01, command)
    if sim_time:
        graph.lockstep(ticks)
    else:
        graph.until(lambda: count >= ticks, ticks * 0.01 + 5.0)
    return Recording(*received)


def test_the_measured_strip_is_the_model_plus_the_noise(graph: Graph) -> None:
    run = record(graph, 1500)
    power_times = np.round(run.power.times_s, 9)
    model = simulate(default_model(), power_times, run.power.data)

    at = np.searchsorted(power_times, [round(from_stamp(m.header.stamp), 9) for m in run.temperature.messages])
    error_k = np.array([m.temperature + 273.15 for m in run.temperature.messages]) - model.temperature_k[at]
    assert len(run.temperature) == 150
    assert error_k.std() == pytest.approx(0.06, rel=0.15)
    assert abs(error_k.mean()) < 4 * 0.06 / math.sqrt(error_k.size)

    at = np.searchsorted(power_times, np.round(run.displacement.times_s, 9))
    error_m = np.array(run.displacement.data) - model.displacement_m[at]
    assert len(run.displacement) == 1500
    assert error_m.std() == pytest.approx(4e-6, rel=0.05)
    assert abs(error_m.mean()) < 4 * 4e-6 / math.sqrt(error_m.size)
    assert np.ptp(model.displacement_m) > 1e-4, "the strip moved"


def test_the_true_state_is_the_model_to_the_last_digits(graph: Graph) -> None:
    run = record(graph, 500)
    model = simulate(default_model(), np.round(run.power.times_s, 9), run.power.data)
    true_k = np.array([m.temperature for m in run.true_temperature.messages]) + 273.15
    assert np.abs(true_k - model.temperature_k).max() < 1e-9
    assert np.abs(np.array(run.true_displacement.data) - model.displacement_m).max() < 1e-12


@pytest.mark.parametrize("seed", [1, 7])
def test_the_same_seed_gives_the_same_recording(graph: Graph, seed: int) -> None:
    with open_graph() as other:
        one, two = record(graph, 300, seed=seed), record(other, 300, seed=seed)
    assert one.displacement.data == two.displacement.data
    assert one.displacement.times_s == two.displacement.times_s
    assert one.temperature.messages == two.temperature.messages
    assert one.power.data == two.power.data


def test_real_time_is_simulated_time_within_the_noise(graph: Graph) -> None:
    run = record(graph, 300, sim_time=False)
    times = np.array(run.power.times_s)
    model = simulate(default_model(), times, run.power.data)
    displacement = np.interp(run.displacement.times_s, times, model.displacement_m)
    error_m = np.array(run.displacement.data) - displacement
    assert error_m.std() < 5e-6 and abs(error_m.mean()) < 1e-6
    error_k = np.array([m.temperature + 273.15 for m in run.temperature.messages]) - np.interp(
        [from_stamp(m.header.stamp) for m in run.temperature.messages], times, model.temperature_k
    )
    assert len(error_k) >= 27
    pairs = zip(run.temperature.times_s, run.temperature.messages, strict=True)
    assert all(from_stamp(m.header.stamp) < received_s for received_s, m in pairs), "no stamp of the future"
    assert error_k.std() < 0.1 and abs(error_k.mean()) < 0.05


def test_the_strip_is_silent_until_it_has_found_a_laser(graph: Graph) -> None:
    graph.add(Simulator, sim_time=True)
    probe = graph.probe(sim_time=True)
    truth = graph.collect(Float64, "sim/displacement", probe)
    graph.lockstep(5)
    assert len(truth) == 0
    laser = probe.advertise(Float64, "laser/power")
    graph.lockstep(5)
    assert len(truth) == 5
    probe.destroy_publisher(laser)
    graph.lockstep(5)
    assert len(truth) == 10


def test_a_power_that_waited_while_the_strip_stood_still_brings_no_light_back(graph: Graph) -> None:
    graph.add(Simulator)
    probe = graph.probe()
    laser, truth = probe.advertise(Float64, "laser/power"), graph.collect(Temperature, "sim/temperature", probe)
    graph.until(lambda: len(truth) > 5 and laser.get_subscription_count() > 0, 20.0, "a strip that has found a laser")
    for _ in range(5):
        laser.publish(Float64(data=2.0))
    time.sleep(0.5)  # as long as the executor of the strip stands still
    before = len(truth)
    graph.until(lambda: len(truth) > before + 30, 20.0, "samples after the stall")
    after = [m.temperature for m in truth.messages[before + 2 :]]
    assert after == sorted(after, reverse=True)


def test_the_strip_carries_the_load_that_is_published(graph: Graph) -> None:
    graph.add(Simulator, sim_time=True, set=["load_stretch.compliance=0.005"])
    probe = graph.probe(sim_time=True)
    probe.advertise(Float64, "laser/power")
    loads, truth = probe.advertise(Float64, "load"), graph.collect(Float64, "sim/displacement", probe)
    graph.lockstep(5)
    before = truth.data[-1]
    loads.publish(Float64(data=0.1))
    graph.lockstep(5)
    assert truth.data[-1] == pytest.approx(before - 5e-4, abs=1e-9)


def test_a_sensor_without_a_strip_publishes_nothing_and_says_so(graph: Graph) -> None:
    probe = graph.probe()
    graph.add(ThermalCamera)
    graph.add(DistanceSensor)
    truth = probe.advertise(Float64, "sim/displacement")
    received = graph.collect(Float64, "displacement", probe)
    diagnostics = graph.collect(DiagnosticArray, "/diagnostics", probe)
    graph.until(lambda: truth.get_subscription_count() == 1)
    truth.publish(Float64(data=1e-3))
    graph.until(lambda: len(received) == 1)

    def silent() -> set[str]:
        return {node_of(s.name) for m in diagnostics.messages for s in m.status if "no reading for" in s.message}

    graph.until(lambda: silent() == {"/lce/thermal_camera", "/lce/distance_sensor"}, 5.0, "the report of silence")
    assert len(received) == 1


def test_a_displacement_is_also_told_with_the_time_of_its_acquisition(graph: Graph) -> None:
    graph.add(DistanceSensor, sim_time=True, latency_s=0.05)
    probe = graph.probe(sim_time=True)
    truth = probe.advertise(Float64, "sim/displacement")
    plain = graph.collect(Float64, "displacement", probe)
    stamped = graph.collect(Float64Stamped, "displacement_stamped", probe)
    graph.lockstep(20, lambda: truth.publish(Float64(data=1e-3)))
    assert [m.value for m in stamped.messages] == plain.data
    stamps_s = np.array([from_stamp(m.header.stamp) for m in stamped.messages])
    assert len(stamps_s) >= 10
    np.testing.assert_allclose(np.array(stamped.times_s) - stamps_s, 0.05, atol=1e-6)


def test_noise_and_latency_can_be_changed_live_within_their_ranges(graph: Graph) -> None:
    sensor = graph.add(DistanceSensor)
    [result] = sensor.set_parameters([Parameter("noise_rms", value=0.0)])
    assert result.successful
    assert sensor._device._sensor.imperfection.noise_rms == 0.0
    [result] = sensor.set_parameters([Parameter("latency_s", value=2.0)])
    assert not result.successful and "latency_s" in result.reason


@pytest.mark.parametrize(
    ("parameter", "words"),
    [
        ({"model_file": "/nowhere/m.yaml"}, ("/nowhere/m.yaml",)),
        ({"set": "['lumped.gain=-3']"}, ("lumped.gain", "-3", "1e+06")),
        ({"set": "['gain=3']"}, ("gain", "lumped.gain")),
    ],
)
def test_a_model_that_does_not_fit_is_one_line_and_status_1(
    graph: Graph, parameter: dict[str, str], words: tuple[str, ...]
) -> None:
    process = graph.start("lce_drivers.simulation.simulator_node", **parameter)
    _, error = process.communicate(timeout=30)
    assert process.returncode == 1
    assert error.count("\n") == 1
    assert all(word in error for word in words)


def test_every_node_tells_its_state_at_1_hz(graph: Graph) -> None:
    nodes = [graph.add(n, sim_time=True) for n in (Laser, Simulator, ThermalCamera, DistanceSensor)]
    diagnostics = graph.collect(DiagnosticArray, "/diagnostics", graph.probe(sim_time=True))
    graph.lockstep(305)
    for node in nodes:
        name = f"{node.get_fully_qualified_name()}: {node.reports_on}"
        own = [s for m in diagnostics.messages for s in m.status if s.name == name]
        assert len(own) == 3
        assert own[-1].level == b"\x00"
        assert len(own[-1].values) >= 2
