# SPDX-License-Identifier: Apache-2.0
"""The node that watches the bench for the page: any topic with a number, on demand, and markers; no commands."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu, Temperature
from std_msgs.msg import Bool, Float64, String

from lce_app.workbench.live_series import MONITORED, Series
from lce_app.workbench.snapshot import Snapshot
from lce_app.workbench.topic_monitor_node import TopicMonitorNode
from lce_data.marker import LONGEST
from lce_data.topics import DIAGNOSTICS, MARKER
from lce_experiment.access import EVERY_NODE
from lce_ros.testing import Graph

FAST = QoSProfile(reliability=ReliabilityPolicy.BEST_EFFORT, depth=5)
KEPT = QoSProfile(reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL, depth=1)

pytestmark = pytest.mark.ros


class Watch:
    """A node under test, and all that it has handed over."""

    def __init__(self, graph: Graph) -> None:
        self.snapshots: list[Snapshot] = []
        self.node: TopicMonitorNode = graph.add(lambda **options: TopicMonitorNode(self.snapshots.append, **options))

    def values(self, series: Series) -> list[float]:
        """All numbers of a series."""
        found = [s.samples[series] for s in self.snapshots if series in s.samples]
        return [value for _, values in found for value in np.frombuffer(values, np.float32).tolist()]

    @property
    def paths(self) -> dict[str, tuple[str, ...]]:
        """What can be watched, as it was last told."""
        told = [snapshot.topics for snapshot in self.snapshots if snapshot.topics is not None]
        return {topic.name: topic.paths for topic in told[-1]} if told else {}


def publishing(graph: Graph, kind: type, topic: str, message: Any, qos: QoSProfile | int = 10) -> Callable[[], None]:
    """A publisher of a probe, and what sends the message."""
    out = graph.probe(f"probe_{topic.replace('/', '_')}").create_publisher(kind, topic, qos)
    return lambda: out.publish(message)


def test_every_number_of_the_namespace_can_be_watched(graph: Graph) -> None:
    watch = Watch(graph)
    for kind, topic in ((Imu, "imu"), (Bool, "lamp"), (String, "word"), (Temperature, "room"), (Float64, "/other/x")):
        publishing(graph, kind, topic, kind())
    graph.until(lambda: {"/lce/imu", "/lce/lamp", "/lce/room"} <= watch.paths.keys(), what="the topics")
    assert watch.paths["/lce/room"] == ("temperature", "variance") and watch.paths["/lce/lamp"] == ("data",)
    assert {"orientation.w", "orientation_covariance[8]"} <= set(watch.paths["/lce/imu"])
    assert not {"/lce/word", "/other/x", f"/lce/{MARKER}"} & watch.paths.keys()


def test_a_topic_is_received_while_it_is_shown_and_no_longer(graph: Graph) -> None:
    watch = Watch(graph)
    message = Imu()
    message.orientation.y, message.orientation_covariance[4] = 0.25, 0.5
    send = publishing(graph, Imu, "imu", message, FAST)
    out = graph.nodes[-1]
    graph.until(lambda: "/lce/imu" in watch.paths, what="the topic")
    assert out.count_subscribers("imu") == 0
    y, covariance = Series("/lce/imu", "orientation.y"), Series("/lce/imu", "orientation_covariance[4]")
    watch.node.watch({y, covariance})
    graph.until(lambda: out.count_subscribers("imu") == 1, what="a subscription, even to a best-effort publisher")
    graph.until(lambda: (send(), watch.values(covariance))[1], what="samples")
    assert watch.values(y)[0] == 0.25 and watch.values(covariance)[0] == 0.5
    watch.node.watch(())
    graph.until(lambda: out.count_subscribers("imu") == 0, what="the end of the subscription")
    before = len(watch.snapshots)
    graph.until(lambda: (send(), len(watch.snapshots) > before + 3)[1], what="snapshots")
    assert all(not snapshot.samples for snapshot in watch.snapshots[before + 1 :])


def test_a_topic_that_comes_later_is_watched_then(graph: Graph) -> None:
    watch = Watch(graph)
    later = Series("/lce/later", "data")
    watch.node.watch({later})
    graph.until(lambda: watch.snapshots, what="a snapshot")
    send = publishing(graph, Float64, "later", Float64(data=2.5))
    graph.until(lambda: (send(), watch.values(later))[1], what="a sample")
    assert set(watch.values(later)) == {2.5}


def test_every_sample_comes_with_the_time_at_which_it_was_sent(graph: Graph) -> None:
    watch = Watch(graph)
    fast = Series("/lce/fast", "data")
    out = graph.probe("sender").create_publisher(Float64, "fast", 200)
    watch.node.watch({fast})
    graph.until(out.get_subscription_count, what="the node")
    for k in range(100):
        out.publish(Float64(data=float(k)))
        graph.executor.spin_once(timeout_sec=0.0)
    graph.until(lambda: len(watch.values(fast)) >= 100, what="the samples")
    assert watch.values(fast) == [float(k) for k in range(100)]
    times = np.concatenate([np.frombuffer(s.samples[fast][0]) for s in watch.snapshots if fast in s.samples])
    assert np.all(np.diff(times) > 0.0) and abs(times[-1] - watch.node.now_s()) < 10.0


def test_a_value_that_holds_is_shown_as_long_as_it_holds(graph: Graph) -> None:
    watch = Watch(graph)
    publishing(graph, Float64, "held", Float64(data=0.5), KEPT)()
    held = Series("/lce/held", "data")
    watch.node.watch({held})
    graph.until(lambda: len(watch.values(held)) > 4, what="samples of one message")
    assert set(watch.values(held)) == {0.5}


def test_numbers_among_the_diagnostics_can_be_watched(graph: Graph) -> None:
    watch = Watch(graph)
    values = [KeyValue(key="age_s", value="0.25"), KeyValue(key="word", value="high")]
    status = DiagnosticStatus(name="/lce/pump: flow", values=values)
    send = publishing(graph, DiagnosticArray, DIAGNOSTICS, DiagnosticArray(status=[status]))
    age = Series(DIAGNOSTICS, "/lce/pump: flow.age_s")
    watch.node.watch({age})
    graph.until(lambda: (send(), age.path in watch.paths.get(DIAGNOSTICS, ()))[1], what="its name")
    graph.until(lambda: (send(), watch.values(age))[1], what="a sample")
    assert set(watch.values(age)) == {0.25}
    assert not any("word" in path for path in watch.paths[DIAGNOSTICS])


@pytest.mark.parametrize("path", ["nothing", "__class__", "data.real", "data[0]", ""])
def test_a_path_that_is_none_is_left_alone(graph: Graph, path: str) -> None:
    """A layout that came from elsewhere may name any."""
    watch = Watch(graph)
    send = publishing(graph, Float64, "laser/power", Float64(data=1.0))
    watch.node.watch({Series("/lce/laser/power", path), Series("/lce/laser/power", "data")})
    graph.until(lambda: (send(), watch.values(Series("/lce/laser/power", "data")))[1], what="the other series")
    assert watch.values(Series("/lce/laser/power", path)) == []


def test_a_marker_is_a_line_of_a_log_with_the_time_of_the_event(graph: Graph) -> None:
    watch = Watch(graph)
    heard = graph.collect(Log, MARKER, graph.probe("listener"))
    graph.until(lambda: watch.node.count_subscribers(MARKER) == 2, what="the listener")
    watch.node.mark('lamp "on"\n<b>\x00 ä\U0001f600' + "x" * 300, age_s=2.0)
    graph.until(lambda: len(heard) and any(snapshot.markers for snapshot in watch.snapshots), what="the marker")
    (message,), (marker,) = heard.messages, [m for s in watch.snapshots for m in s.markers]
    assert message.msg.startswith('lamp "on" <b> ä\U0001f600xxx') and len(message.msg) == LONGEST
    assert message.msg == marker.text and message.name == "/lce/workbench" and message.level == 20
    assert marker.time_s == pytest.approx(watch.node.now_s() - 2.0, abs=1.0)


def test_a_marker_of_others_is_shown_as_well(graph: Graph) -> None:
    watch = Watch(graph)
    send = publishing(graph, Log, MARKER, Log(msg="by hand"))
    graph.until(lambda: (send(), any(s.markers for s in watch.snapshots))[1], what="the marker")
    (marker, *_) = [m for s in watch.snapshots for m in s.markers]
    assert marker.text == "by hand" and marker.time_s == pytest.approx(watch.node.now_s(), abs=5.0), "without a stamp"


def test_the_page_commands_nothing(graph: Graph) -> None:
    watch = Watch(graph)
    every = {f"/lce/workbench{name[1:]}" if name.startswith("~") else name for name in EVERY_NODE.publishes}
    name = watch.node.get_name(), watch.node.get_namespace()
    published = {topic for topic, _ in watch.node.get_publisher_names_and_types_by_node(*name)}
    assert published == every | {f"/lce/{MARKER}"}
    assert watch.node.get_client_names_and_types_by_node(*name) == []
    heard = {topic for topic, _ in watch.node.get_subscriber_names_and_types_by_node(*name)}
    assert heard == {f"/lce/{topic}" for topic in (*MONITORED, MARKER)} | {DIAGNOSTICS}
