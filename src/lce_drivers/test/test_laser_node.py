# SPDX-License-Identifier: Apache-2.0
"""The laser node on a graph of its own, in process and as the process that it is on the bench."""

import math
import signal
import subprocess

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import Log
from rclpy.parameter import Parameter
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger

from lce_drivers.laser.laser_node import Laser
from lce_interfaces.msg import Float64Stamped
from lce_ros.conversions import from_stamp
from lce_ros.node import LceNode, NodeFault
from lce_ros.testing import Graph, Received

pytestmark = pytest.mark.alone

LASER = "lce_drivers.laser.laser_node"
ALONE = {"temperature_required": False, "max_tick_gap_s": 0.5, "command_fault_s": 2.0}
"""No camera, and a machine that others load: it stands still now and then."""


class Commander:
    """Commands the laser at 100 Hz and listens to what it makes of it."""

    def __init__(self, graph: Graph, sim_time: bool = False) -> None:
        self.node: LceNode = graph.probe("commander", sim_time=sim_time)
        self.publisher = self.node.advertise(Float64, "laser/power_command")
        self.power: Received = graph.collect(Float64, "laser/power", self.node)
        self.command: float | None = None
        self.node.every(0.01, self._tick)

    def _tick(self) -> None:
        if self.command is not None:
            self.publisher.publish(Float64(data=self.command))

    def last(self) -> float | None:
        return self.power.messages[-1].data if self.power.messages else None


def shining(graph: Graph, power_w: float = 0.5) -> tuple[Commander, subprocess.Popen[str]]:
    process = graph.start(LASER, **ALONE)
    commander = Commander(graph)
    commander.command = power_w
    graph.until(lambda: commander.last() == power_w, 20.0, "the laser shining")
    return commander, process


def test_the_laser_follows_in_100_hz(graph: Graph) -> None:
    commander = Commander(graph, sim_time=True)
    graph.add(Laser, sim_time=True, **ALONE)
    commander.command = 0.5
    graph.lockstep(102)
    assert len(commander.power) == 102
    assert commander.power.data[2:] == [0.5] * 100


def test_power_and_command_are_also_told_with_their_times(graph: Graph) -> None:
    commander = Commander(graph, sim_time=True)
    power, command = (
        graph.collect(Float64Stamped, topic, commander.node)
        for topic in ("laser/power_stamped", "laser/power_command_stamped")
    )
    laser = graph.add(Laser, sim_time=True, **ALONE)
    commander.command = 0.5
    graph.lockstep(10)
    commander.command = None
    graph.lockstep(15)
    laser.close()
    graph.until(lambda: len(power) == 26 and commander.last() == 0.0)
    times_s = [from_stamp(m.header.stamp) for m in power.messages]
    assert times_s == pytest.approx([*commander.power.times_s[:25], 0.25])
    assert [m.value for m in power.messages] == commander.power.data
    assert [m.value for m in command.messages] == [0.5] * 10
    assert [from_stamp(m.header.stamp) for m in command.messages] == pytest.approx([0.01 * k for k in range(1, 11)])


def test_in_real_time_a_command_has_the_time_at_which_it_was_published(graph: Graph) -> None:
    commander = Commander(graph)
    power, command = (
        graph.collect(Float64Stamped, topic, commander.node)
        for topic in ("laser/power_stamped", "laser/power_command_stamped")
    )
    graph.add(Laser, **ALONE)
    commander.command = 0.5
    graph.until(lambda: any(m.value == 0.5 for m in power.messages))
    lit_s = next(from_stamp(m.header.stamp) for m in power.messages if m.value == 0.5)
    sent_s = from_stamp(command.messages[0].header.stamp)
    assert 0.0 < lit_s - sent_s < 0.1
    assert sent_s < command.times_s[0]


def test_zero_until_the_first_command_and_after_the_last(graph: Graph) -> None:
    commander = Commander(graph)
    graph.add(Laser, **ALONE)
    graph.until(lambda: len(commander.power) >= 20)
    assert set(commander.power.data) == {0.0}
    commander.command = 1.0
    graph.until(lambda: commander.last() == 1.0)
    commander.command = None
    graph.until(lambda: commander.last() == 0.0)


def test_the_time_out_is_exact_in_simulated_time(graph: Graph) -> None:
    commander = Commander(graph, sim_time=True)
    graph.add(Laser, sim_time=True, **ALONE)
    graph.until(lambda: commander.publisher.get_subscription_count() == 1)
    commander.command = 1.0
    graph.lockstep(10)
    commander.command = None
    graph.lockstep(20)
    ticks = {round(t * 100): v for t, v in zip(commander.power.times_s, commander.power.data, strict=True)}
    assert [ticks[k] for k in range(1, 31)] == [0.0] + [1.0] * 19 + [0.0] * 10


@pytest.mark.parametrize("command", [math.nan, math.inf, -math.inf, -0.5])
def test_nonsense_is_a_fault_and_an_error_in_the_diagnostics(graph: Graph, command: float) -> None:
    commander = Commander(graph)
    graph.add(Laser, **ALONE)
    diagnostics = graph.collect(DiagnosticArray, "/diagnostics", commander.node)
    commander.command = 0.5
    graph.until(lambda: commander.last() == 0.5)
    commander.command = command
    graph.until(lambda: commander.last() == 0.0)
    commander.command = 0.25
    graph.spin_for(0.3)
    assert commander.last() == 0.0, "it stays dark until a reset"

    def errors() -> list[str]:
        own = [s for m in diagnostics.messages for s in m.status if s.name == "/lce/laser: output"]
        return [s.message for s in own if s.level == b"\x02"]

    graph.until(errors, 3.0, "an error in the diagnostics")
    assert "not a power" in errors()[0]
    assert all(math.isfinite(p) and 0.0 <= p <= 2.0 for p in commander.power.data)


def test_a_command_above_the_limit_is_limited_and_the_limit_can_be_lowered_live(graph: Graph) -> None:
    commander = Commander(graph)
    laser = graph.add(Laser, max_power_w=1.5, **ALONE)
    commander.command = 50.0
    graph.until(lambda: commander.last() == 1.5)
    [result] = laser.set_parameters([Parameter("max_power_w", value=0.75)])
    assert result.successful
    graph.until(lambda: commander.last() == 0.75)


@pytest.mark.parametrize(
    ("name", "value"),
    [("max_power_w", 11.0), ("max_power_w", math.nan), ("command_timeout_s", 5.0), ("device", "x")],
)
def test_parameters_out_of_range_are_refused_live_and_at_the_start(graph: Graph, name: str, value: object) -> None:
    laser = graph.add(Laser, **ALONE)
    [result] = laser.set_parameters([Parameter(name, value=value)])
    assert not result.successful and name in result.reason
    with pytest.raises(ValueError, match=name):
        Laser(context=graph.context, parameter_overrides=[Parameter(name, value=value)])


def test_limits_that_leave_no_temperature_are_refused_at_the_start(graph: Graph) -> None:
    with pytest.raises(ValueError, match=r"max_temperature_c: -45 °C is not above min_temperature_c, -40 °C"):
        graph.add(Laser, max_temperature_c=-45.0)


@pytest.mark.parametrize("active", [True, False])
def test_a_commander_that_is_not_heard_yet_is_reported(graph: Graph, active: bool) -> None:
    first, second = Commander(graph), graph.probe("rival")
    laser = graph.add(Laser, autostart=active, **ALONE)
    if not active:
        laser.trigger_configure()
    second.advertise(Float64, "laser/power_command")
    diagnostics = graph.collect(DiagnosticArray, "/diagnostics", first.node)
    graph.until(
        lambda: any(
            "2 nodes could publish laser/power_command" in s.message for m in diagnostics.messages for s in m.status
        ),
        4.0,
        "the report",
    )
    said: list[Log] = []
    first.node.create_subscription(Log, "/rosout", said.append, 10)
    graph.until(lambda: (first.node.get_logger().info("here"), said)[1], what="the log")
    graph.spin_for(2.5)
    assert [m.msg for m in said if m.name == "lce.laser"] == [], "it was logged once, when it came up"


def test_two_commanders_are_a_fault_before_the_bigger_one_wins(graph: Graph) -> None:
    commander, process = shining(graph)
    rival = graph.probe("rival")
    rivals = rival.advertise(Float64, "laser/power_command")
    graph.until(lambda: rivals.get_subscription_count() >= 1)
    armed = graph.collect(Bool, "laser/armed", rival)
    before = len(commander.power)
    timer = rival.every(0.02, lambda: rivals.publish(Float64(data=1.5)))
    graph.until(lambda: armed.data == [False], 5.0, "the fault")
    graph.spin_for(0.3)
    assert sum(power > 0.5 for power in commander.power.data[before:]) <= 2
    assert set(commander.power.data[-20:]) == {0.0}
    timer.cancel()
    graph.spin_for(1.2)
    assert graph.call(commander.node, Trigger, "laser/reset").success
    process.terminate()


def test_a_commander_killed_and_started_again_is_no_rival_of_itself(graph: Graph) -> None:
    """The middleware goes on to count the killed one for seconds."""
    graph.add(Laser, **ALONE | {"command_fault_s": 0.5})
    watcher = graph.probe("watcher")
    power = graph.collect(Float64, "laser/power", watcher)
    player = {"protocol": "hold:power=0.5,hold=20,rest=0.5", "lead_s": 0.2}
    first = graph.start("lce_experiment.nodes.experiment_player_node", **player)
    graph.until(lambda: power.data and power.data[-1] == 0.5, 20.0, "light")
    graph.kill(first)
    graph.until(lambda: power.data[-1] == 0.0, 3.0, "darkness")
    graph.spin_for(0.7)
    assert graph.call(watcher, Trigger, "laser/reset").success
    assert graph.call(watcher, SetBool, "laser/arm", data=True).success
    graph.start("lce_experiment.nodes.experiment_player_node", **player)
    graph.until(lambda: power.data[-1] == 0.5, 20.0, "light of the second one")


def test_a_laser_that_was_held_up_with_the_light_on_stays_dark(graph: Graph) -> None:
    commander, process = shining(graph)
    process.send_signal(signal.SIGSTOP)
    graph.spin_for(0.8)
    commander.power.messages.clear()
    process.send_signal(signal.SIGCONT)
    graph.until(lambda: len(commander.power) > 50, what="a laser that speaks again")
    # What it had computed when it was stopped it may still publish.
    assert not any(commander.power.data[1:])
    answer = graph.call(commander.node, Trigger, "laser/reset")
    assert answer.success and "stood still" in answer.message
    refusal = graph.call(commander.node, SetBool, "laser/arm", data=True)
    assert not refusal.success and "0.5 W are commanded" in refusal.message


def test_a_commander_that_was_held_up_with_the_light_on_gets_no_light_back(graph: Graph) -> None:
    graph.add(Laser, **ALONE | {"command_fault_s": 0.5})
    power = graph.collect(Float64, "laser/power", graph.probe("watcher"))
    player = graph.start("lce_experiment.nodes.experiment_player_node", protocol="hold:power=0.5,hold=60,rest=0.5")
    graph.until(lambda: power.data and power.data[-1] == 0.5, 20.0, "light")
    player.send_signal(signal.SIGSTOP)
    graph.spin_for(1.0)
    assert power.data[-1] == 0.0
    player.send_signal(signal.SIGCONT)
    power.messages.clear()
    graph.until(lambda: len(power) > 100)
    assert not any(power.data)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_stop_signal_leaves_zero_as_the_last_word_and_status_0(graph: Graph, number: signal.Signals) -> None:
    commander, process = shining(graph)
    process.send_signal(number)
    graph.until(lambda: commander.last() == 0.0, 20.0, "zero power")
    graph.until(lambda: process.poll() is not None, 20.0, "the end of the process")
    graph.spin_for(0.05)
    assert commander.last() == 0.0
    assert process.returncode == 0
    assert process.stderr is not None
    assert [line for line in process.stderr if not line.startswith(("[INFO]", "[WARN]"))] == []


def test_an_exception_in_a_callback_leaves_zero_and_a_traceback_and_status_1(graph: Graph) -> None:
    commander, process = shining_then_failing(graph, "raise RuntimeError('burnt')")
    assert process.returncode == 1
    assert process.stderr is not None and "RuntimeError: burnt" in process.stderr.read()
    assert commander.last() == 0.0


def test_a_shutdown_of_ros_within_the_process_ends_it_in_order(graph: Graph) -> None:
    _, process = shining_then_failing(graph, "import rclpy; rclpy.shutdown()")
    assert process.returncode == 0


def shining_then_failing(graph: Graph, statement: str) -> tuple[Commander, subprocess.Popen[str]]:
    """A laser whose own timer runs a statement once it has followed commands for a while."""
    code = f"""
import sys
from lce_drivers.laser.power_guard import State
from lce_drivers.laser.laser_node import Laser
from lce_ros.node import run
class Failing(Laser):
    def __init__(self):
        super().__init__()
        self.lit = 0
        self.create_timer(0.1, self.fail)
    def fail(self):
        self.lit += self._guard.state is State.FOLLOWING
        if self.lit > 5:
            {statement}
sys.exit(run(Failing))
"""
    process = graph.start(LASER, **ALONE, code=code)
    commander = Commander(graph)
    commander.command = 0.5
    graph.until(lambda: commander.last() == 0.5, 20.0, "the laser shining")
    graph.until(lambda: process.poll() is not None, 20.0, "the end of the process")
    graph.spin_for(0.05)
    return commander, process


def test_a_clock_that_stands_still_ends_the_node(graph: Graph) -> None:
    laser = graph.add(Laser, **ALONE)
    graph.spin_for(0.3)
    for timer in laser.timers:
        if timer.clock is laser.get_clock():
            timer.cancel()
    with pytest.raises(NodeFault, match="clock was set back"):
        graph.spin_for(2.0)


def test_a_bad_parameter_is_one_line_and_status_1(graph: Graph) -> None:
    process = graph.start(LASER, **ALONE, max_power_w=99.0)
    out, error = process.communicate(timeout=20)
    assert process.returncode == 1
    assert out == "" and error.count("\n") == 1
    assert all(word in error for word in ("laser", "max_power_w", "99", "10"))
