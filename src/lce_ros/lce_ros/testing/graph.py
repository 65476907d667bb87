# SPDX-License-Identifier: Apache-2.0
"""Nodes under test on a ROS graph: own domain, simulated time tick by tick, conditions with time-outs, no sleeps."""

import math
import os
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, Final

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.utilities import try_shutdown
from rosgraph_msgs.msg import Clock

from lce_ros.conversions import to_stamp
from lce_ros.domain import free_domain
from lce_ros.node import LceNode
from lce_ros.qos import deeper
from lce_ros.testing.processes import end, kill, start

ASK_AGAIN_S: Final = 3.0
"""Time after which a service that has not answered is asked again [s]."""


@dataclass
class Received:
    """Messages of a topic with the times [s] at which they came."""

    messages: list[Any] = field(default_factory=list)
    times_s: list[float] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.messages)

    @property
    def data(self) -> list[float]:
        """The ``data`` fields of the messages."""
        return [m.data for m in self.messages]


class Graph:
    """Nodes under test in one process and one executor, in a ROS domain that nobody else uses."""

    def __init__(self, domain: int) -> None:
        self.domain = domain
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.nodes: list[LceNode] = []
        self.processes: list[subprocess.Popen[str]] = []
        self._clock: Any = None
        self.time_s = 0.0

    def add(self, factory: Callable[..., LceNode], *args: Any, sim_time: bool = False, **parameters: Any) -> Any:
        """Make a node in the namespace /lce with parameters, and let it spin with the others."""
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        if sim_time:
            overrides.append(Parameter("use_sim_time", value=True))
        node = factory(*args, context=self.context, namespace="/lce", parameter_overrides=overrides)
        self.executor.add_node(node)
        self.nodes.append(node)
        return node

    def probe(self, name: str = "probe", sim_time: bool = False) -> LceNode:
        """A plain node to publish and listen with."""
        node: LceNode = self.add(lambda **options: LceNode(name, **options), sim_time=sim_time)
        return node

    def collect(self, msg_type: Any, topic: str, node: LceNode) -> Received:
        """Collect what is published on ``topic``, stamped with the clock of ``node``."""
        received, name = Received(), node.resolve_topic_name(topic)
        node.received.setdefault(name, 0)

        def keep(message: Any) -> None:
            received.messages.append(message)
            received.times_s.append(node.now_s())
            node.received[name] += 1

        node.create_subscription(msg_type, topic, keep, deeper(1000))
        return received

    def until(self, condition: Callable[[], Any], timeout_s: float = 10.0, what: str = "the condition") -> Any:
        """Spin until the condition holds; AssertionError after the time-out."""
        deadline = time.monotonic() + timeout_s
        while not (result := condition()):
            assert time.monotonic() < deadline, f"{what} did not come true within {timeout_s:g} s"
            self.executor.spin_once(timeout_sec=0.02)
        return result

    def spin_for(self, duration_s: float) -> None:
        """Spin for ``duration_s`` [s] of real time."""
        deadline = time.monotonic() + duration_s
        while (left := deadline - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def call(self, node: LceNode, srv_type: Any, name: str, **fields: Any) -> Any:
        """The answer of a service to the request with these fields.

        It is asked again if no answer comes: rmw_fastrtps drops one for a client that the service has not found yet.
        """
        client = node.create_client(srv_type, name)
        self.until(client.service_is_ready, 20.0, name)
        answers, asked_s = list[Any](), -math.inf

        def answered() -> Any:
            nonlocal asked_s
            if time.monotonic() > asked_s + ASK_AGAIN_S:
                answers.append(client.call_async(srv_type.Request(**fields)))
                asked_s = time.monotonic()
            return next((answer for answer in answers if answer.done()), None)

        answer = self.until(answered, what=f"an answer of {name}")
        node.destroy_client(client)
        return answer.result()

    def connect(self) -> None:
        """Spin until the nodes of this process have found each other."""
        self.until(self._connected, what="discovery")

    def lockstep(self, ticks: int, each: Callable[[], None] = lambda: None, step_s: float = 0.01) -> None:
        """Advance simulated time tick by tick; ``each`` runs before every tick, all is at rest after it."""
        self.connect()
        if self._clock is None:
            node = rclpy.create_node("clock", context=self.context)
            self.executor.add_node(node)
            self._clock = node.create_publisher(Clock, "/clock", 10)
        for _ in range(ticks):
            each()
            self.time_s = round(self.time_s + step_s, 9)
            self._clock.publish(Clock(clock=to_stamp(self.time_s)))
            self.until(self.at_rest, what=f"rest after the tick at {self.time_s} s")

    def _connected(self) -> bool:
        listeners = Counter(topic for node in self.nodes for topic in node.received)
        publishers = [p for node in self.nodes for p in node.publishers]
        talkers = Counter(p.topic_name for p in publishers)
        subscriptions = [s for node in self.nodes for s in node.subscriptions]
        return all(p.get_subscription_count() >= listeners[p.topic_name] for p in publishers) and all(
            s.get_publisher_count() >= talkers[s.topic_name] for s in subscriptions
        )

    def at_rest(self) -> bool:
        """Whether every clock shows the time, every due timer has fired and every message has been received."""
        if any(abs(node.now_s() - self.time_s) > 1e-9 for node in self.nodes):
            return False
        if any(timer.is_ready() for node in self.nodes for timer in node.timers):
            return False
        sent: Counter[str] = Counter()
        for node in self.nodes:
            sent.update(node.published)
        return all(count >= sent[topic] for node in self.nodes for topic, count in node.received.items())

    def start(self, module: str, *, code: str | None = None, **parameters: Any) -> "subprocess.Popen[str]":
        """Run a node module (or Python ``code``) as a process of its own, in this domain and namespace."""
        process = start(self.domain, module, code, parameters)
        self.processes.append(process)
        return process

    @staticmethod
    def kill(process: "subprocess.Popen[str]") -> None:
        """SIGKILL, and clear away the shared memory that a killed process leaves behind."""
        kill(process)

    def close(self) -> None:
        """Close the nodes and end the processes."""
        for node in self.nodes:
            node.close()
        for process in self.processes:
            end(process)
        self.executor.shutdown(timeout_sec=1.0)
        for node in self.nodes:
            node.destroy_node()
        try_shutdown(context=self.context)


@contextmanager
def open_graph() -> Iterator[Graph]:
    """A graph in a domain of its own, closed at the end; as a fixture: ``with open_graph() as g: yield g``."""
    with free_domain() as domain:
        g = Graph(domain)
        try:
            yield g
        finally:
            g.close()
