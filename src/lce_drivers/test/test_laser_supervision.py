# SPDX-License-Identifier: Apache-2.0
"""The laser node and the temperature of the strip, in simulated time: to the tick."""

import math
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter
from sensor_msgs.msg import Temperature
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from lce_drivers.laser.laser_node import Laser
from lce_ros.conversions import to_stamp
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone


class Supervised:
    """A laser, half a watt of command at 100 Hz, and a camera at 10 Hz that shows what it is told."""

    def __init__(self, graph: Graph, **parameters: Any) -> None:
        self.graph = graph
        self.laser = graph.add(Laser, sim_time=True, **parameters)
        self.node = graph.probe(sim_time=True)
        self.power = graph.collect(Float64, "laser/power", self.node)
        self.diagnostics = graph.collect(DiagnosticArray, "/diagnostics", self.node)
        self.commands = self.node.advertise(Float64, "laser/power_command")
        self.camera = self.node.advertise(Temperature, "temperature")
        self.client = self.node.create_client(Trigger, "laser/reset")
        self.command_w: float | None = 0.5
        self.shown_c: float | None = 40.0
        self.node.every(0.01, self._command)
        self.node.every(0.1, self._show)
        graph.connect()

    def _command(self) -> None:
        if self.command_w is not None:
            self.commands.publish(Float64(data=self.command_w))

    def _show(self) -> None:
        if self.shown_c is not None:
            message = Temperature(temperature=self.shown_c)
            message.header.stamp = to_stamp(self.node.tick_s)
            self.camera.publish(message)

    def run(self, ticks: int) -> list[float]:
        """Powers [W] of as many ticks."""
        before = len(self.power)
        self.graph.lockstep(ticks)
        return self.power.data[before:]

    def reset(self) -> Trigger.Response:
        self.graph.until(self.client.service_is_ready)
        future = self.client.call_async(Trigger.Request())
        response: Trigger.Response = self.graph.until(lambda: future.result() if future.done() else None)
        return response

    def said(self) -> list[str]:
        return [s.message for m in self.diagnostics.messages for s in m.status if s.name == "/lce/laser"]


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
    [(None, "no temperature for 0.5 s"), (120.5, "0.5 K above"), (math.nan, "is nan"), (60.0, "jumped by 20.0 K")],
)
def test_a_fault_is_zero_until_it_is_reset(graph: Graph, shown_c: float | None, reason: str) -> None:
    supervised = shining(graph)
    supervised.shown_c = shown_c
    assert supervised.run(60)[-1] == 0.0
    supervised.shown_c = 40.0
    assert set(supervised.run(200)) == {0.0}, "light does not come back by itself"
    assert reason in supervised.said()[-1] and "laser/reset" in supervised.said()[-1]
    answer = supervised.reset()
    assert answer.success and reason in answer.message
    assert supervised.run(10)[-1] == 0.5


def test_too_hot_is_zero_with_the_reading_that_says_so(graph: Graph) -> None:
    supervised = shining(graph, max_temperature_c=45.0)
    supervised.shown_c = 45.5
    powers = supervised.run(11)
    assert powers[-1] == 0.0 and supervised.reset().message.startswith("not cleared, the strip is 0.5 K above")
    supervised.shown_c = 44.0
    assert set(supervised.run(20)) == {0.0}
    assert supervised.reset().success and supervised.run(5)[-1] == 0.5


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
    powers = supervised.run(20)
    assert powers[0] <= 0.01 + 1e-9 and powers[-1] == pytest.approx(powers[0] + 0.19)


def test_the_limits_are_live(graph: Graph) -> None:
    supervised = shining(graph)
    [result] = supervised.laser.set_parameters([Parameter("max_temperature_c", value=39.0)])
    assert result.successful
    assert supervised.run(15)[-1] == 0.0
    [result] = supervised.laser.set_parameters([Parameter("temperature_pause_s", value=0.6)])
    assert not result.successful and "temperature_pause_s" in result.reason
