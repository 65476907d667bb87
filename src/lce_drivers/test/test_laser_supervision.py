# SPDX-License-Identifier: Apache-2.0
"""The laser node and the temperature of the strip, in simulated time: to the tick."""

import math
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter
from sensor_msgs.msg import Temperature
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger

from lce_drivers.laser.laser_node import Laser
from lce_ros.conversions import to_stamp
from lce_ros.testing import Graph

pytestmark = [pytest.mark.alone, pytest.mark.flaky(reruns=0)]


class Supervised:
    """A laser, half a watt of command at 100 Hz, and a camera at 10 Hz that shows what it is told, and some noise."""

    def __init__(self, graph: Graph, **parameters: Any) -> None:
        self.graph = graph
        self.laser = graph.add(Laser, sim_time=True, **parameters)
        self.node = graph.probe(sim_time=True)
        self.power = graph.collect(Float64, "laser/power", self.node)
        self.diagnostics = graph.collect(DiagnosticArray, "/diagnostics", self.node)
        self.commands = self.node.advertise(Float64, "laser/power_command")
        self.camera = self.node.advertise(Temperature, "temperature")
        self.armed = graph.collect(Bool, "laser/armed", self.node)
        self.command_w: float | None = 0.5
        self.shown_c: float | None = 40.0
        self.noise_c, self.ahead_s = 0.01, 0.0
        self.node.every(0.01, self._command)
        self.node.every(0.1, self._show)
        graph.connect()

    def _command(self) -> None:
        if self.command_w is not None:
            self.commands.publish(Float64(data=self.command_w))

    def _show(self) -> None:
        if self.shown_c is not None:
            self.noise_c = -self.noise_c
            message = Temperature(temperature=self.shown_c + self.noise_c)
            message.header.stamp = to_stamp(self.node.tick_s + self.ahead_s)
            self.camera.publish(message)

    def run(self, ticks: int) -> list[float]:
        """Powers [W] of as many ticks."""
        before = len(self.power)
        self.graph.lockstep(ticks)
        return self.power.data[before:]

    def reset(self) -> Trigger.Response:
        return self.graph.call(self.node, Trigger, "laser/reset")

    def arm(self, on: bool = True) -> SetBool.Response:
        return self.graph.call(self.node, SetBool, "laser/arm", data=on)

    def relit(self) -> bool:
        """Whether there is light after a reset, a command of zero, arming and a command, and not before."""
        dark = [self.reset().success, set(self.run(20)) == {0.0}, not self.arm().success]
        self.command_w = 0.0
        dark += [set(self.run(5)) == {0.0}, self.arm().success]
        self.command_w = 0.5
        return all(dark) and self.run(10)[-1] == 0.5

    def said(self) -> list[str]:
        return [s.message for m in self.diagnostics.messages for s in m.status if s.name == "/lce/laser: output"]


def shining(graph: Graph, **parameters: Any) -> Supervised:
    supervised = Supervised(graph, **parameters)
    assert supervised.run(50)[-30:] == [0.5] * 30
    return supervised


def test_no_light_without_a_camera_unless_that_is_declared(graph: Graph) -> None:
    supervised = Supervised(graph)
    supervised.shown_c = None
    assert set(supervised.run(100)) == {0.0}
    assert "no temperature for 0.5 s" in supervised.said()[-1]


def test_a_bench_without_a_camera_can_be_declared(graph: Graph) -> None:
    supervised = Supervised(graph, temperature_required=False)
    supervised.shown_c = None
    assert supervised.run(100)[-90:] == [0.5] * 90
    [result] = supervised.laser.set_parameters([Parameter("temperature_required", value=True)])
    assert not result.successful, "not while it shines"


def test_a_silent_camera_is_zero_after_200_ms_and_light_again_with_the_next_reading(graph: Graph) -> None:
    supervised = shining(graph)
    supervised.shown_c = None
    powers = supervised.run(40)
    assert 15 <= powers.index(0.0) <= 21 and set(powers[powers.index(0.0) :]) == {0.0}
    supervised.shown_c = 40.0
    assert supervised.run(15)[-1] == 0.5


@pytest.mark.parametrize(
    ("shown_c", "reason"),
    [
        (None, "no temperature for 0.5 s"),
        (120.5, "0.5 K above"),
        (-300.0, "260.0 K below what the camera can measure"),
        (math.nan, "is nan"),
        (60.0, "jumped by 20.0 K"),
    ],
)
def test_a_fault_is_zero_until_it_is_reset_and_armed(graph: Graph, shown_c: float | None, reason: str) -> None:
    supervised = shining(graph)
    supervised.shown_c = shown_c
    assert supervised.run(60)[-1] == 0.0
    supervised.shown_c = 40.0
    assert set(supervised.run(200)) == {0.0}, "light does not come back by itself"
    assert reason in supervised.said()[-1] and "laser/reset" in supervised.said()[-1]
    assert not supervised.arm().success, "not over a fault"
    assert supervised.relit()
    assert supervised.armed.data == [True, False, True]


@pytest.mark.parametrize("shown_c", [-300.0, -40.5])
def test_a_temperature_that_cannot_be_is_not_reset(graph: Graph, shown_c: float) -> None:
    supervised = shining(graph)
    supervised.shown_c = shown_c
    assert supervised.run(15)[-1] == 0.0
    answer = supervised.reset()
    assert not answer.success and "below what the camera can measure" in answer.message


def test_a_frozen_camera_is_a_fault_while_there_is_light(graph: Graph) -> None:
    supervised = shining(graph)
    supervised.noise_c = 0.0
    powers = supervised.run(150)
    assert 90 <= powers.index(0.0) <= 121 and set(powers[powers.index(0.0) :]) == {0.0}
    assert "as if frozen" in supervised.said()[-1] and "as if frozen" in supervised.reset().message
    supervised.noise_c = 0.01
    supervised.run(20)
    assert supervised.relit()


def test_a_camera_without_noise_can_be_declared_for_the_node(graph: Graph) -> None:
    supervised = shining(graph, frozen_after_s=0.0)
    supervised.noise_c = 0.0
    assert set(supervised.run(300)) == {0.5}


@pytest.mark.parametrize("ahead_s", [0.006, 0.15])
def test_readings_of_the_future_are_none(graph: Graph, ahead_s: float) -> None:
    supervised = shining(graph)
    supervised.ahead_s = ahead_s
    powers = supervised.run(160)
    assert powers.index(0.0) <= 21 and set(powers[powers.index(0.0) :]) == {0.0}
    assert f"readings are stamped {ahead_s:.3f} s in the future" in supervised.said()[-1]


@pytest.mark.parametrize("topic", ["laser/power_command", "temperature"])
def test_a_second_publisher_is_a_fault_until_it_is_gone(graph: Graph, topic: str) -> None:
    supervised = shining(graph)
    rival = graph.probe("rival", sim_time=True)
    kind: Any = Float64 if topic == "laser/power_command" else Temperature
    publisher, speaks = rival.advertise(kind, topic), [False]

    def speak() -> None:
        message = kind(data=0.5) if kind is Float64 else kind(temperature=40.0)
        if kind is Temperature:
            message.header.stamp = to_stamp(rival.tick_s)
        if speaks[0]:
            publisher.publish(message)

    rival.every(0.1, speak)
    assert set(supervised.run(100)) == {0.5}, "a publisher that is silent does no harm"
    speaks[0] = True
    powers = supervised.run(30)
    assert powers.index(0.0) <= 20 and set(powers[powers.index(0.0) :]) == {0.0}
    answer = supervised.reset()
    assert not answer.success and f"two nodes still publish {topic}" in answer.message
    speaks[0] = False
    assert set(supervised.run(120)) == {0.0}
    assert supervised.relit()


def test_a_commander_that_falls_silent_with_the_light_on_is_a_fault(graph: Graph) -> None:
    supervised = shining(graph)
    supervised.command_w = None
    assert supervised.run(40).index(0.0) <= 12
    supervised.command_w = 0.5
    assert supervised.run(10)[-1] == 0.5, "a pause of less than half a second"
    supervised.command_w = None
    supervised.run(60)
    supervised.command_w = 0.5
    assert set(supervised.run(50)) == {0.0}
    assert "no command for 0.5 s after one of 0.5 W" in supervised.reset().message
    assert supervised.relit()


def test_disarming_is_zero_at_once_and_leaves_no_fault(graph: Graph) -> None:
    supervised = shining(graph)
    assert supervised.arm(False).success
    assert set(supervised.run(20)) == {0.0} and supervised.armed.data[-1] is False
    assert "0.5 W are commanded" in supervised.arm().message
    assert supervised.reset().message == "there was no fault"
    assert supervised.relit()


def test_a_disarming_lasts_until_every_controller_could_hear_of_it(graph: Graph) -> None:
    supervised = Supervised(graph)
    supervised.command_w = 0.0
    supervised.run(50)
    supervised.arm(False)
    assert "call again" in supervised.arm().message, "not told yet"
    supervised.run(5)
    assert "call again" in supervised.arm().message
    supervised.run(10)
    assert supervised.arm().success and supervised.run(2) and supervised.armed.data == [True, False, True]


def test_too_hot_is_zero_with_the_reading_that_says_so(graph: Graph) -> None:
    supervised = shining(graph, max_temperature_c=45.0)
    supervised.shown_c = 45.5
    powers = supervised.run(11)
    assert powers[-1] == 0.0 and supervised.reset().message.startswith("not cleared, the strip is 0.5 K above")
    supervised.shown_c = 44.0
    assert set(supervised.run(20)) == {0.0}
    assert supervised.relit()


def test_a_dark_bench_has_no_fault_and_a_reset_of_nothing_is_no_error(graph: Graph) -> None:
    supervised = Supervised(graph)
    supervised.shown_c = supervised.command_w = None
    supervised.run(200)
    assert supervised.reset().message == "there was no fault"
    assert not any("fault" in said for said in supervised.said())


def test_the_light_rises_from_zero_at_the_slew_limit_after_a_reset(graph: Graph) -> None:
    supervised = Supervised(graph, slew_w_per_s=1.0)
    supervised.run(100)
    supervised.shown_c = math.nan
    assert supervised.run(20)[-1] == 0.0
    supervised.shown_c = 40.0
    supervised.run(20)
    supervised.reset()
    supervised.command_w = 0.0
    supervised.run(2)
    supervised.arm()
    supervised.command_w = 0.5
    powers = [power for power in supervised.run(24) if power > 0.0][:20]
    assert powers[0] <= 0.01 + 1e-9 and powers[-1] == pytest.approx(powers[0] + 0.19)


def test_the_limits_can_only_be_tightened(graph: Graph) -> None:
    supervised = shining(graph)
    for name, value in (
        ("max_power_w", 10.0), ("max_temperature_c", 300.0), ("min_temperature_c", -90.0), ("max_jump_k", 1000.0),
        ("command_timeout_s", 0.4), ("command_fault_s", 5.0), ("max_tick_gap_s", 1.0), ("temperature_pause_s", 0.4),
        ("temperature_fault_s", 5.0), ("frozen_after_s", 0.0), ("slew_w_per_s", 1e6), ("temperature_required", False),
    ):  # fmt: skip
        [result] = supervised.laser.set_parameters([Parameter(name, value=value)])
        assert not result.successful and name in result.reason, name
    [result] = supervised.laser.set_parameters([Parameter("max_temperature_c", value=-45.0)])
    assert not result.successful and "not above min_temperature_c" in result.reason
    [result] = supervised.laser.set_parameters([Parameter("max_temperature_c", value="cool")])
    assert not result.successful
    [result] = supervised.laser.set_parameters([Parameter("max_temperature_c", value=39.0)])
    assert result.successful
    assert supervised.run(15)[-1] == 0.0
    [result] = supervised.laser.set_parameters([Parameter("max_temperature_c", value=40.0)])
    assert not result.successful and "can only be lowered" in result.reason
