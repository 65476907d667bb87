# SPDX-License-Identifier: Apache-2.0
"""The controller nodes on the simulated strip, in lockstep: the double loop, the single one, the model-based one."""

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.parameter import Parameter
from sensor_msgs.msg import Temperature
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool

from lce_experiment import config, registry
from lce_experiment.runners.lockstep import Lockstep
from lce_model import default_model, save_model
from lce_ros.conversions import from_stamp, to_stamp
from lce_ros.testing import Graph, Received, open_graph

TARGET_M = 1.5e-3
STRIP = default_model("lumped", "kinetic").set({"lumped.gain": 73.0})


class Bench:
    """The simulated bench under a mode of control, with an operator who sets targets and listens."""

    def __init__(self, g: Graph, mode: str, folder: Path, **parameters: dict[str, Any]) -> None:
        save_model(STRIP, folder / "strip.yaml")
        given: dict[str, dict[str, Any]] = {
            "simulator": {"model_file": str(folder / "strip.yaml")},
            "feedforward": {"model_file": str(folder / "strip.yaml"), "branch": "actual"},
            "model_controller": {"model_file": str(folder / "strip.yaml")},
        }
        for name, content in yaml.safe_load(config.config_file("control.yaml").read_text()).items():
            given.setdefault(name.removeprefix("/**/"), {}).update(content["ros__parameters"])
        for name, values in parameters.items():
            given.setdefault(name, {}).update(values)
        self.nodes = {
            spec.name: g.add(spec.load(), sim_time=True, **given.get(spec.name, {}))
            for spec in (*registry.BENCH, *registry.CONTROLLERS[mode])
        }
        self.operator = g.probe("operator", sim_time=True)
        self.targets = self.operator.advertise(Float64, "target_displacement", latched=True)
        topics = {
            "laser/power": Float64,
            "laser/power_command": Float64,
            "sim/displacement": Float64,
            "temperature_setpoint": Temperature,
        }
        self.received = {topic: g.collect(kind, topic, self.operator) for topic, kind in topics.items()}
        self.diagnostics: Received = g.collect(DiagnosticArray, "/diagnostics", self.operator)
        self._arm = self.operator.create_client(SetBool, "laser/arm")
        self.steps = Lockstep(g.nodes)

    def follow(self, target_m: float, duration_s: float) -> np.ndarray:
        """Set a target; the displacement [m] at 100 Hz from then on."""
        before = len(self.received["sim/displacement"])
        self.targets.publish(Float64(data=target_m))
        self.wait(duration_s)
        return np.array(self.received["sim/displacement"].data[before:])

    def wait(self, duration_s: float) -> None:
        """Let simulated time pass."""
        for _ in range(round(duration_s * 100)):
            self.steps.tick()

    def arm(self, on: bool) -> bool:
        """Arm or disarm the laser; whether it did."""
        answer = self._arm.call_async(SetBool.Request(data=on))
        self.steps.tick()
        return bool(answer.result().success)

    def said(self, name: str) -> list[str]:
        """The messages of a node in /diagnostics so far."""
        return [s.message for s in self.statuses(name)]

    def statuses(self, name: str) -> list[DiagnosticStatus]:
        """The statuses of a node in /diagnostics so far."""
        return [s for m in self.diagnostics.messages for s in m.status if s.name.startswith(f"/lce/{name}:")]


@contextmanager
def control(g: Graph, mode: str, folder: Path, **parameters: dict[str, Any]) -> Iterator[Bench]:
    b = Bench(g, mode, folder, **parameters)
    try:
        yield b
    finally:
        b.steps.close()


@pytest.mark.parametrize("mode", registry.CONTROLLERS)
def test_a_target_is_reached_and_held(graph: Graph, tmp_path: Path, mode: str) -> None:
    with control(graph, mode, tmp_path) as b:
        d = b.follow(TARGET_M, 60.0)
        power = np.array(b.received["laser/power"].data)
    assert np.sqrt(np.mean((d[4000:] / TARGET_M - 1.0) ** 2)) < 0.05
    assert power.max() <= 2.0 and power[-1] > 0.0


@pytest.mark.parametrize("mode", registry.CONTROLLERS)
def test_the_same_seed_gives_the_same_loop(graph: Graph, tmp_path: Path, mode: str) -> None:
    powers = []
    with open_graph() as other:
        for g in (graph, other):
            with control(g, mode, tmp_path) as b:
                b.follow(TARGET_M, 5.0)
                b.follow(0.8e-3, 5.0)
                powers.append(b.received["laser/power"].data)
    assert powers[0] == powers[1] and max(powers[0]) > 0.5


def test_setpoint_and_command_come_in_100_hz_and_in_the_tick_of_the_sensor(graph: Graph, tmp_path: Path) -> None:
    with control(graph, "double", tmp_path) as b:
        b.follow(TARGET_M, 2.0)
        times = {name: np.array(received.times_s[-150:]) for name, received in b.received.items()}
    for name in ("temperature_setpoint", "laser/power_command"):
        np.testing.assert_allclose(times[name], times["sim/displacement"], atol=1e-9)
    stamps = [from_stamp(m.header.stamp) for m in b.received["temperature_setpoint"].messages[-150:]]
    np.testing.assert_allclose(stamps, times["temperature_setpoint"], atol=1e-6)


@pytest.mark.parametrize("mode", registry.CONTROLLERS)
def test_a_target_out_of_reach_is_refused_with_the_range_and_the_last_one_stays(
    graph: Graph, tmp_path: Path, mode: str, capfd: pytest.CaptureFixture[str]
) -> None:
    [node] = [spec.name for spec in registry.CONTROLLERS[mode] if spec in registry.TARGET_LISTENERS]
    with control(graph, mode, tmp_path) as b:
        b.follow(9.0e-3, 2.0)
        assert set(b.received["laser/power"].data) == {0.0}
        assert "9.000 mm is out of reach" in b.said(node)[-1] and "there is no target" in b.said(node)[-1]
        lower, upper = map(float, re.findall(r"(-?\d+\.\d+) to (\d+\.\d+) mm", b.said(node)[-1])[0])
        assert lower < 0.1 and 2.0 < upper < 6.0
        b.follow(TARGET_M, 30.0)
        d = b.follow(math.nan, 20.0)
        assert "1.500 mm stays the target" in b.said(node)[-1]
        np.testing.assert_allclose(d, TARGET_M, rtol=0.1)
        b.follow(1.4e-3, 2.5)
        assert b.said(node)[-1] == "controlling"
    assert "target refused: 9.000 mm is out of reach" in capfd.readouterr().err


@pytest.mark.parametrize("mode", ["double", "model"])
@pytest.mark.parametrize("silent", ["distance_sensor", "thermal_camera"])
def test_without_a_fresh_measurement_zero_is_commanded(graph: Graph, tmp_path: Path, silent: str, mode: str) -> None:
    with control(graph, mode, tmp_path) as b:
        b.follow(TARGET_M, 3.0)
        assert b.received["laser/power_command"].data[-1] > 0.0
        b.nodes[silent].set_parameters([Parameter("latency_s", value=1.0)])
        before = len(b.received["laser/power_command"])
        b.wait(0.5)
        commands = b.received["laser/power_command"].data[before:]
    dark = commands.index(0.0)
    assert dark <= 22 and set(commands[dark:]) == {0.0}
    assert len(commands) >= 47, "100 Hz all the same"


@pytest.mark.parametrize("mode", registry.CONTROLLERS)
@pytest.mark.parametrize(
    ("name", "value"), [("quantum", 0.02), ("latency_s", 0.6)], ids=["it repeats 0 mm", "nothing for 0.6 s"]
)
def test_a_distance_sensor_that_fails_is_zero_power_until_somebody_arms_again(
    graph: Graph, tmp_path: Path, mode: str, name: str, value: float
) -> None:
    [node] = [spec.name for spec in registry.CONTROLLERS[mode] if spec in registry.TARGET_LISTENERS]
    with control(graph, mode, tmp_path) as b:
        b.follow(TARGET_M, 3.0)
        sensor, before = b.nodes["distance_sensor"], len(b.received["laser/power"])
        assert b.received["laser/power"].data[-1] > 0.0
        sensor.set_parameters([Parameter(name, value=value)])
        b.wait(0.8)
        sensor.set_parameters([Parameter("quantum", value=1e-6)])
        b.wait(3.0)
        power_w = b.received["laser/power"].data[before:]
        assert set(power_w[20:]) == {0.0}, "dark within 200 ms, and when the sensor is well again"
        assert b.said(node)[-1].startswith("fault: ")
        assert b.arm(False)
        b.wait(0.2)  # until every controller knows
        assert b.arm(True)
        b.wait(1.0)
        assert max(b.received["laser/power"].data[-90:]) > 0.0


@pytest.mark.parametrize("mode", registry.CONTROLLERS)
def test_while_the_laser_is_not_armed_zero_is_commanded_so_that_it_can_be_armed(
    graph: Graph, tmp_path: Path, mode: str
) -> None:
    with control(graph, mode, tmp_path) as b:
        b.follow(TARGET_M, 3.0)
        assert b.arm(False)
        before = len(b.received["laser/power_command"])
        b.wait(5.0)
        assert set(b.received["laser/power_command"].data[before + 3 :]) == {0.0}
        assert b.arm(True)
        d = b.follow(TARGET_M, 20.0)
    np.testing.assert_allclose(d[-200:], TARGET_M, rtol=0.1)


@pytest.mark.parametrize(
    ("setpoint_c", "ahead_s", "lit"),
    [(80.0, 0.0, True), (math.inf, 0.0, False), (math.nan, 0.0, False), (80.0, 60.0, False)],
)
def test_nonsense_at_the_inner_loop_is_zero_power(graph: Graph, setpoint_c: float, ahead_s: float, lit: bool) -> None:
    """A setpoint that is no number, or a temperature of another clock's future, which would never become stale."""
    graph.add(registry.INNER.load(), sim_time=True)
    operator = graph.probe("operator", sim_time=True)
    setpoints, camera = (operator.advertise(Temperature, topic) for topic in ("temperature_setpoint", "temperature"))
    commands = graph.collect(Float64, "laser/power_command", operator)

    def publish() -> None:
        measured = Temperature(temperature=28.0)
        measured.header.stamp = to_stamp(graph.time_s + ahead_s)
        camera.publish(measured)
        setpoints.publish(Temperature(temperature=setpoint_c))

    graph.lockstep(20, publish)
    assert len(commands) >= 15 and (commands.data[-1] > 0.0) is lit


@pytest.mark.parametrize("last_c", [None, math.nan])
def test_a_setpoint_that_falls_silent_is_zero_power_until_somebody_arms_again(
    graph: Graph, last_c: float | None
) -> None:
    """Silent, as one whose node was killed, or NaN, as that of an outer controller that has a fault."""
    graph.add(registry.INNER.load(), sim_time=True)
    operator = graph.probe("operator", sim_time=True)
    setpoints, camera = (operator.advertise(Temperature, topic) for topic in ("temperature_setpoint", "temperature"))
    armed = operator.advertise(Bool, "laser/armed", latched=True)
    commands = graph.collect(Float64, "laser/power_command", operator)

    def measure() -> None:
        measured = Temperature(temperature=28.0)
        measured.header.stamp = to_stamp(graph.time_s)
        camera.publish(measured)

    def publish(setpoint_c: float = 80.0) -> None:
        measure()
        setpoints.publish(Temperature(temperature=setpoint_c))

    graph.lockstep(20, publish)
    assert commands.data[-1] > 0.0
    graph.lockstep(70, measure if last_c is None else lambda: publish(last_c))
    before = len(commands)
    graph.lockstep(50, publish)
    assert set(commands.data[before:]) == {0.0}, "the outer controller is back"
    for on in (False, True):
        armed.publish(Bool(data=on))
        graph.lockstep(5, publish)
    assert commands.data[-1] > 0.0


def test_gains_are_live_within_their_ranges_and_do_not_move_the_command(graph: Graph, tmp_path: Path) -> None:
    calm = {
        "outer_controller": {"kp": 3000.0, "ki": 1500.0, "kd": 0.0},
        "inner_controller": {"kp": 1.0, "ki": 0.1, "kd": 0.0},
    }
    with control(graph, "double", tmp_path, **calm) as b:
        b.follow(TARGET_M, 20.0)
        inner = b.nodes["inner_controller"]
        last = b.received["laser/power_command"].data[-1]
        [result] = inner.set_parameters([Parameter("kp", value=0.3)])
        assert result.successful
        b.wait(0.01)
        assert b.received["laser/power_command"].data[-1] == pytest.approx(last, abs=0.02), (
            "0.3 W/K would be 0.5 W less"
        )
        for name, value in (("kp", -1.0), ("n", 0.0), ("filter_s", 60.0), ("max_power_w", math.nan)):
            [result] = inner.set_parameters([Parameter(name, value=value)])
            assert not result.successful and name in result.reason
        for name, lower, higher in (("setpoint_timeout_s", 0.05, 0.09), ("setpoint_fault_s", 0.3, 5.0)):
            assert [inner.set_parameters([Parameter(name, value=x)])[0].successful for x in (lower, higher)] == [
                True,
                False,
            ]
        descriptor = inner.describe_parameter("ki")
        assert "W/(K s)" in descriptor.description and descriptor.floating_point_range[0].from_value == 0.0


def test_the_actual_branch_is_that_of_the_way_the_strip_has_come(graph: Graph, tmp_path: Path) -> None:
    """After the strip was hot, the same displacement is found at a lower temperature."""
    with control(graph, "double", tmp_path) as b:
        asked = []
        for target_m in (1.0e-3, 2.2e-3, 1.0e-3):
            b.follow(target_m, 15.0)
            status = b.statuses("outer_controller")[-1]
            asked.append(float(next(v.value for v in status.values if v.key == "feedforward_c")))
    assert asked[2] < asked[0] - 2.0 < asked[1]


def test_by_the_model_targets_are_met_from_either_side_within_one_percent(graph: Graph, tmp_path: Path) -> None:
    with control(graph, "model", tmp_path) as b:
        for target_m in (2.0e-3, 1.2e-3, 1.6e-3):
            d = b.follow(target_m, 30.0)
            assert np.abs(d[-500:] / target_m - 1.0).max() < 0.01
            beyond = (d - target_m) * np.sign(target_m - d[0])
            assert beyond.max() < 0.01 * target_m


def test_by_the_model_a_stream_of_targets_is_a_trajectory(graph: Graph, tmp_path: Path) -> None:
    with control(graph, "model", tmp_path) as b:
        b.follow(1.0e-3, 10.0)
        ramp_m = np.linspace(1.0e-3, 2.0e-3, 1000)
        error_m = np.array([b.follow(float(target_m), 0.01)[-1] for target_m in ramp_m]) - ramp_m
    assert np.abs(error_m[200:]).max() < 20e-6, "100 µm/s: the target of 0.2 s before would be 20 µm off"
