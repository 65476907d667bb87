# SPDX-License-Identifier: Apache-2.0
import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import Log
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Float64

from lce_ros.health import Level
from lce_ros.node import LceNode, Stop
from lce_ros.qos import deeper
from lce_ros.testing import Graph

pytestmark = pytest.mark.alone
LATCHED_MOST = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Example(LceNode):
    reports_on = "gain"

    def __init__(self, **options: Any) -> None:
        super().__init__("example", **options)
        self.declare("gain", 1.0, "a gain", unit="W", lower=0.0, upper=2.0)
        self.declare("count", 3, "a number", lower=0, upper=10)
        self.declare("mode", "a", "a choice", choices=("a", "b"))
        self.declare("fixed", 1.0, "not live", read_only=True)
        self.declare("free", 1.0, "no range")
        self.fired: list[tuple[float, float]] = []


def test_ticks_are_on_multiples_of_the_period(graph: Graph) -> None:
    nodes = [graph.add(Example) for _ in range(2)]
    for node in nodes:
        node.every(0.01, lambda node=node: node.fired.append((node.tick_s, node.now_s())))
    graph.until(lambda: all(len(n.fired) >= 50 for n in nodes))
    for node in nodes:
        nominal, actual = np.array(node.fired).T
        assert np.abs(nominal / 0.01 - np.round(nominal / 0.01)).max() < 1e-3
        assert (actual >= nominal - 1e-6).all()
        assert len(set(np.round(nominal / 0.01))) == len(nominal)


def test_ticks_follow_simulated_time(graph: Graph) -> None:
    node = graph.add(Example, sim_time=True)
    node.every(0.05, lambda: node.fired.append((node.tick_s, node.now_s())))
    graph.lockstep(20)
    assert np.allclose(np.array(node.fired)[:, 0], [0.05, 0.1, 0.15, 0.2])
    assert np.allclose(np.array(node.fired)[:, 1], [0.05, 0.1, 0.15, 0.2])
    assert node.ticks == 4


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("gain", 2.5, ("2.5", "0.0", "2.0")),
        ("gain", math.nan, ("nan", "0.0", "2.0")),
        ("gain", math.inf, ("inf", "0.0", "2.0")),
        ("count", 11, ("11", "0", "10")),
        ("mode", "c", ("'c'", "a, b")),
        ("free", math.nan, ("nan",)),
        ("fixed", 2.0, ("read-only", "fixed")),
        ("use_sim_time", True, ("use_sim_time", "start")),
        ("gain", "big", ("DOUBLE", "STRING")),
    ],
)
def test_a_live_change_out_of_range_is_refused_with_value_and_range(
    graph: Graph, name: str, value: Any, words: tuple[str, ...]
) -> None:
    node = graph.add(Example)
    before = node.value(name)
    [result] = node.set_parameters([Parameter(name, value=value)])
    assert not result.successful
    for word in words:
        assert word in result.reason
    assert node.value(name) == before


def test_a_live_change_of_use_sim_time_leaves_the_clock_alone(graph: Graph) -> None:
    node = graph.add(Example)
    node.every(0.01, lambda: node.fired.append((node.tick_s, node.now_s())))
    for result in node.set_parameters([Parameter("use_sim_time", value=value) for value in (True, False)]):
        assert result.successful == (result.reason == "")
    assert node.now_s() > 1e9 and not node.on_sim_time
    graph.until(lambda: len(node.fired) >= 3)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        ({"gain": 3.0}, ("example", "gain", "3.0", "0.0", "2.0")),
        ({"gain": 1}, ("gain", "DOUBLE", "2.0, not 2")),
        ({"mode": "c"}, ("example", "mode", "'c'", "a, b")),
    ],
)
def test_a_node_does_not_start_with_a_parameter_out_of_range(
    graph: Graph, overrides: dict[str, Any], words: tuple[str, ...]
) -> None:
    with pytest.raises(ValueError, match=words[0]) as caught:
        graph.add(Example, **overrides)
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


MISSPELT = """
import sys
from lce_ros.node import LceNode, run

class Example(LceNode):
    def __init__(self):
        super().__init__("example")
        self.declare("gain", 1.0, "a gain")
        self.declare("device", "a", "what it speaks to", choices=("a", "b"))

sys.exit(run(Example))
"""


def test_a_parameter_that_the_node_does_not_have_is_named_in_its_log(graph: Graph) -> None:
    said: list[Log] = []
    graph.probe().create_subscription(Log, "/rosout", said.append, LATCHED_MOST)
    others = {"b.port": 3, "qos_overrides./lce/x.subscription.depth": 3}
    graph.start("", code=MISSPELT, gian=0.5, **others)
    graph.until(lambda: any("no parameter" in m.msg for m in said), what="the warning")
    graph.spin_for(0.2)
    assert [(m.name, m.level, m.msg) for m in said if "no parameter" in m.msg] == [
        ("lce.example", 30, "there is no parameter gian: it is ignored (did you mean 'gain'?)")
    ]


def test_descriptors_tell_range_unit_and_choices(graph: Graph) -> None:
    node = graph.add(Example)
    gain, mode = node.describe_parameters(["gain", "mode"])
    assert gain.floating_point_range[0].to_value == 2.0
    assert "[W]" in gain.description
    assert mode.additional_constraints == "one of a, b"


def test_messages_are_counted_on_both_sides(graph: Graph) -> None:
    node = graph.add(Example)
    received: list[float] = []
    node.listen(Float64, "topic", lambda m: received.append(m.data))
    publisher = node.advertise(Float64, "topic")
    graph.until(lambda: publisher.get_subscription_count() == 1)
    for i in range(3):
        publisher.publish(Float64(data=float(i)))
    graph.until(lambda: len(received) == 3)
    assert node.published["/lce/topic"] == node.received["/lce/topic"] == 3


def test_a_latched_topic_reaches_who_comes_later(graph: Graph) -> None:
    node = graph.add(Example)
    node.advertise(Float64, "target", latched=True).publish(Float64(data=1.5))
    received: list[float] = []
    node.listen(Float64, "target", lambda m: received.append(m.data), latched=True)
    graph.until(lambda: received == [1.5])


@pytest.mark.parametrize("latched", [True, False])
def test_who_listens_to_a_latched_topic_hears_each_message_of_any_publisher_once(graph: Graph, latched: bool) -> None:
    node = graph.add(Example)
    said: list[Log] = []
    graph.probe("reader").create_subscription(Log, "/rosout", said.append, deeper(100))
    graph.connect()
    received: list[float] = []
    both = node.listen(Float64, "target", lambda m: received.append(m.data), latched=True)
    publisher = graph.probe().advertise(Float64, "target", latched=latched)
    graph.until(lambda: publisher.get_subscription_count() == 1 + latched and both.get_publisher_count() == 1)
    for value in (1.0, 2.0, 3.0):
        publisher.publish(Float64(data=value))
        graph.until(partial(received.__contains__, value))
    graph.spin_for(0.1)
    assert received == [1.0, 2.0, 3.0]
    assert node.received["/lce/target"] == 3
    assert not any(line.name == "lce.example" and "incompatible" in line.msg for line in said)


def test_a_fault_of_one_tick_is_seen_once_on_diagnostics(graph: Graph) -> None:
    node = graph.add(Example, sim_time=True)
    probe = graph.probe(sim_time=True)
    received = graph.collect(DiagnosticArray, "/diagnostics", probe)
    graph.until(lambda: node.count_subscribers("/diagnostics") == 1)
    node.hardware_id = "example 7"
    node.report(Level.ERROR, "broken", power_w=0.25)
    node.report(Level.OK, "well again")
    graph.lockstep(205)
    own = [m.status[0] for m in received.messages if m.status[0].name == "/lce/example: gain"]
    assert {s.hardware_id for s in own} == {"example 7"}
    assert [(s.level[0], s.message) for s in own] == [(2, "broken"), (0, "well again")]
    assert {v.key: v.value for v in own[0].values} == {"power_w": "0.25", "missed_ticks": "0"}


def test_ticks_that_were_left_out_are_counted(graph: Graph) -> None:
    node = graph.add(Example, sim_time=True)
    node.every(0.01, lambda: node.fired.append((node.tick_s, node.now_s())))
    graph.lockstep(5)
    graph.lockstep(1, step_s=0.04)
    graph.lockstep(1)
    assert np.allclose([nominal for nominal, _ in node.fired], [0.01, 0.02, 0.03, 0.04, 0.05, 0.09, 0.1])
    assert node.missed_ticks == 3


def test_the_log_tells_a_condition_once_until_it_is_another_one(graph: Graph) -> None:
    node = graph.add(Example, sim_time=True)
    probe = graph.probe(sim_time=True)
    told = graph.collect(Log, "/rosout", probe)
    graph.until(lambda: node.count_subscribers("/rosout") == 1)
    conditions = [(Level.WARN, f"no reading for {k} s") for k in range(1, 4)] + [(Level.OK, "measuring")] * 2
    for condition in conditions:
        node.report(*condition)
        graph.lockstep(100)
    graph.until(lambda: len([m for m in told.messages if m.name == "lce.example"]) == 2)
    own = [(m.level, m.msg) for m in told.messages if m.name == "lce.example"]
    assert own == [(30, "no reading for 1 s"), (20, "measuring")]


def test_the_future_that_ends_a_node_keeps_one_callback_of_a_long_life() -> None:
    stop, called = Stop(), []
    for k in range(1000):
        stop.add_done_callback(lambda _, k=k: called.append(k))
    stop.set_result(None)
    assert called == [0]
    stop.add_done_callback(lambda _: called.append(-1))
    assert called == [0, -1], "as rclpy, at once"
