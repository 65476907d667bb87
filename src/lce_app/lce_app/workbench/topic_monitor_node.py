# SPDX-License-Identifier: Apache-2.0
"""Node `workbench`: receives the topics of the bench and hands over a snapshot of them 15 times a second.

Publishes   marker (when the user marks an event), /diagnostics. Nothing here commands, arms or sets anything.
Subscribes  temperature, displacement, laser/power, laser/power_command, temperature_setpoint, target_displacement,
            marker, /diagnostics; and while a live plot shows it, any topic of its namespace that holds a number
"""

from __future__ import annotations

import math
import os
import signal
from array import array
from collections.abc import Callable, Collection
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Final

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from lce_app.workbench.live_series import MONITORED, Series, TopicFields
from lce_app.workbench.numeric_fields import getter, message_class, numeric_paths
from lce_app.workbench.snapshot import PERIOD_S, Snapshot
from lce_data.marker import Marker, one_line
from lce_data.topics import DIAGNOSTICS, LATCHED_TOPICS, MARKER, RECORDED
from lce_experiment.registry import NAMESPACE
from lce_ros.conversions import from_stamp, to_stamp
from lce_ros.health import node_of
from lce_ros.messages import KINDS, MessageKind
from lce_ros.node import LceNode, run

FORGOTTEN_S: Final = 0.5
"""Age [s] at which a value is dropped; one of a latched topic stays."""
LOOK_S: Final = 1.0
"""Time between two looks at the topics of the graph [s]."""
QUEUE: Final = 200
"""Messages of a watched topic that wait while this node is busy: 2 s at 100 Hz."""

INFO: Final = 20
"""Level of a marker; the constant Log.INFO is a number or a byte, as the release has it."""

Command = frozenset[Series] | tuple[str, float]
"""What the page asks for: to watch these series, or to mark with a text what was so many seconds ago."""


class TopicMonitorNode(LceNode):
    """See the module; ``hand_over`` is called with each snapshot."""

    reports_on = "page"

    def __init__(self, hand_over: Callable[[Snapshot], None], **options: Any) -> None:
        super().__init__("workbench", **options)
        self._hand_over = hand_over
        self._last: dict[str, tuple[float, float]] = {}
        self._conditions: dict[str, tuple[int, str]] = {}
        self._wanted: frozenset[Series] = frozenset()
        self._watched: dict[str, dict[Series, Callable[[Any], float]]] = {}
        self._readers: dict[str, Subscription] = {}
        self._samples: dict[Series, tuple[array[float], array[float]]] = {}
        self._held: dict[Series, float] = {}
        self._reported: dict[str, set[str]] = {}
        self._markers: list[Marker] = []
        self._topics: tuple[TopicFields, ...] = ()
        self._new_topics = False
        for topic in MONITORED:
            kind = KINDS[RECORDED[topic]]
            self.listen(kind.message, topic, partial(self._receive, topic, kind), latched=topic in LATCHED_TOPICS)
        self.listen(DiagnosticArray, DIAGNOSTICS, self._receive_diagnostics)
        self._marker = self.advertise(Log, MARKER)
        self.listen(Log, MARKER, self._receive_marker)
        self._own = {self.resolve_topic_name(topic): topic for topic in MONITORED}
        self._latched = {self.resolve_topic_name(topic) for topic in LATCHED_TOPICS}
        self.every(PERIOD_S, self._tick)
        self.every(LOOK_S, self._look)

    def watch(self, wanted: Collection[Series]) -> None:
        """Hand over the samples of these series from now on, and of no other."""
        self._wanted = frozenset(wanted)
        for topic in self._readers.keys() - {series.topic for series in wanted}:
            self.destroy_subscription(self._readers.pop(topic))
        for kept in (self._samples, self._held):
            for series in [series for series in kept if series not in wanted]:
                del kept[series]
        self._look()

    def mark(self, text: str, age_s: float = 0.0) -> None:
        """Publish a marker of what was ``age_s`` [s] ago."""
        message = Log(level=INFO, name=self.get_fully_qualified_name())
        message.stamp = to_stamp(self.now_s() - age_s)
        message.msg = one_line(text)
        self._marker.publish(message)

    def _receive(self, topic: str, kind: MessageKind, message: Any) -> None:
        value, _ = kind.read(message)
        self._last[topic] = (self.now_s(), float(value))
        self._take(self.resolve_topic_name(topic), message, self.sent_s)

    def _receive_other(self, topic: str, message: Any, info: dict[str, Any]) -> None:
        self._take(topic, message, self.now_s() if self.on_sim_time else info["source_timestamp"] * 1e-9)

    def _take(self, topic: str, message: Any, time_s: float) -> None:
        for series, read in self._watched.get(topic, {}).items():
            self._add(series, time_s, read(message))

    def _add(self, series: Series, time_s: float, value: float) -> None:
        times, values = self._samples.setdefault(series, (array("d"), array("f")))
        times.append(time_s)
        values.append(value)
        if series.topic in self._latched:
            self._held[series] = value

    def _receive_marker(self, message: Log) -> None:
        time_s = from_stamp(message.stamp) or self.now_s()
        self._markers.append(Marker(time_s, one_line(message.msg)))

    def _receive_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if (node := node_of(status.name)) != self.get_fully_qualified_name():
                self._conditions[node] = (status.level[0], status.message)
                self._take_diagnosis(status)

    def _take_diagnosis(self, status: DiagnosticStatus) -> None:
        """Take the numbers among the values that a node reports."""
        told = self._reported.setdefault(status.name, set())
        for entry in status.values:
            try:
                value = float(entry.value)
            except ValueError:
                continue
            series = Series(DIAGNOSTICS, f"{status.name}.{entry.key}")
            self._new_topics |= entry.key not in told
            told.add(entry.key)
            if series in self._wanted:
                self._add(series, self.now_s(), value)

    def _look(self) -> None:
        """Find the topics that can be watched, and subscribe to those that are."""
        front = f"{self.get_namespace().rstrip('/')}/"
        found = [
            TopicFields(name, types[0], numeric_paths(types[0]))
            for name, types in self.get_topic_names_and_types()
            if name.startswith(front) and name != f"{front}{MARKER}" and len(types) == 1
        ]
        of_nodes = tuple(f"{name}.{key}" for name, keys in sorted(self._reported.items()) for key in sorted(keys))
        found.append(TopicFields(DIAGNOSTICS, RECORDED[DIAGNOSTICS], of_nodes))
        topics = tuple(sorted((topic for topic in found if topic.paths), key=lambda topic: topic.name))
        self._new_topics |= topics != self._topics
        self._topics = topics
        self._watched = {
            topic.name: {series: getter(series.path) for series in topic.series if series in self._wanted}
            for topic in topics
        }
        for topic in topics:
            if self._watched[topic.name] and topic.name not in {*self._readers, *self._own, DIAGNOSTICS}:
                self._subscribe(topic)

    def _subscribe(self, topic: TopicFields) -> None:
        """Best effort, which every publisher satisfies; with the last message from before, where all keep it."""
        offered = [info.qos_profile.durability for info in self.get_publishers_info_by_topic(topic.name)]
        latched = bool(offered) and all(durability is DurabilityPolicy.TRANSIENT_LOCAL for durability in offered)
        qos = QoSProfile(
            reliability=ReliabilityPolicy.RELIABLE if latched else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
            history=HistoryPolicy.KEEP_LAST,
            depth=QUEUE,
        )
        receive = partial(self._receive_other, topic.name)
        if latched:
            self._latched.add(topic.name)
        self._readers[topic.name] = self.create_subscription(message_class(topic.type), topic.name, receive, qos)

    def _tick(self) -> None:
        now = self.now_s()
        fresh = {
            topic: value
            for topic, (since, value) in self._last.items()
            if math.isfinite(value) and (topic in LATCHED_TOPICS or now - since < FORGOTTEN_S)
        }
        for series, value in self._held.items():
            if series not in self._samples:
                self._add(series, now, value)
        samples = {series: (times.tobytes(), values.tobytes()) for series, (times, values) in self._samples.items()}
        topics = self._topics if self._new_topics else None
        snapshot = Snapshot(now, fresh, self._conditions, samples, tuple(self._markers), topics)
        self._samples, self._conditions, self._markers, self._new_topics = {}, {}, [], False
        self._hand_over(snapshot)


def monitor_topics(link: Connection, domain: int) -> None:
    """In a process of its own: be the node, until nobody reads the snapshots."""
    node: TopicMonitorNode | None = None

    def hand_over(snapshot: Snapshot) -> None:
        assert node is not None
        try:
            link.send(snapshot)
            while link.poll():
                _obey(node, link.recv())
        except (BrokenPipeError, ConnectionResetError, EOFError):
            signal.raise_signal(signal.SIGINT)

    def made() -> TopicMonitorNode:
        nonlocal node
        node = TopicMonitorNode(hand_over)
        return node

    os.environ["ROS_DOMAIN_ID"] = str(domain)
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    run(made, ["--ros-args", "-r", f"__ns:={NAMESPACE}"])


def _obey(node: TopicMonitorNode, command: Command) -> None:
    match command:
        case frozenset():
            node.watch(command)
        case (text, age_s):
            node.mark(text, age_s)
