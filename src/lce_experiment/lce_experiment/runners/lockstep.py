# SPDX-License-Identifier: Apache-2.0
"""Simulated time for nodes in one process, as quickly as the machine can and the same every time.

A tick sets every node's clock, fires the timers that are due, node by node in the order given, hands over
every message and answers every service call before the next tick begins. Publishing within a process puts a
message straight into the readers' queues, so these are read directly: the wait sets of an executor cost ten
times the work itself.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from typing import Any, cast

from rclpy.client import Client
from rclpy.clock import ROSClock
from rclpy.clock_type import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.time import Time

from lce_data.errors import LceError
from lce_ros.node import LceNode

TICK_NS = 10_000_000
START_NS = 1_000_000_000
"""Where simulated time begins; zero would mean "not set" to ROS."""
_PATIENCE_S = 10.0
_SERVICE_TICKS = 100
"""Ticks between two looks at the service calls of other processes."""


class Lockstep:
    """Drives nodes, made with use_sim_time, one tick at a time. ``now_ns`` is the present simulated time [ns].

    Raises LceError if the nodes do not find each other, or a message or an answer does not arrive, within 10 s.
    """

    def __init__(self, nodes: Sequence[LceNode]) -> None:
        self.now_ns = START_NS
        self._clocks = [cast(ROSClock, node.get_clock()) for node in nodes]
        self._timers = [timer for node in nodes for timer in node.timers]
        self._nodes = nodes
        self._readers: dict[str, list[Subscription]] = {}
        for reader in (reader for node in nodes for reader in node.subscriptions):
            if reader.topic_name != "/clock":
                self._readers.setdefault(reader.topic_name, []).append(reader)
        self._published = {
            topic: [node.published for node in nodes if topic in node.published] for topic in self._readers
        }
        self._delivered: Counter[str] = Counter()
        services = {service.service_name: service for node in nodes for service in node.services}
        clients = [client for node in nodes for client in node.clients]
        self._calls = [(client, services[client.service_name]) for client in clients if client.service_name in services]
        self._executor = SingleThreadedExecutor(context=nodes[0].context)
        for node in nodes:
            self._executor.add_node(node)
        self._wait_for_matches()
        self._set_clocks()

    def tick(self) -> None:
        """Advance 10 ms: every due timer has fired and every message has been received when it returns."""
        self.now_ns += TICK_NS
        self._set_clocks()
        for timer in self._timers:
            while timer.handle.is_timer_ready():
                timer.handle.call_timer()
                timer.callback()
        self._deliver()
        for client, service in self._calls:
            if client._pending_requests:
                self._answer(client, service)
        if self.now_ns // TICK_NS % _SERVICE_TICKS == 0:
            self._executor.spin_once(timeout_sec=0)

    def close(self) -> None:
        """Let go of the nodes."""
        self._executor.shutdown()

    def _set_clocks(self) -> None:
        now = Time(nanoseconds=self.now_ns, clock_type=ClockType.ROS_TIME)
        for clock in self._clocks:
            clock.set_ros_time_override(now)

    def _deliver(self) -> None:
        """Hand over, topic by topic, as many messages as were published, until callbacks publish no more."""
        again = True
        while again:
            again = False
            for topic, readers in self._readers.items():
                due = sum(counts[topic] for counts in self._published[topic]) - self._delivered[topic]
                if due:
                    again = True
                    self._delivered[topic] += due
                    for reader in readers:
                        for _ in range(due):
                            self._hand_over(reader)

    def _answer(self, client: Client, service: Service) -> None:
        """Serve what a client has asked and hand it the answers."""
        end = time.monotonic() + _PATIENCE_S
        while client._pending_requests:
            request, header = service.handle.service_take_request(service.srv_type.Request)
            if header is not None:
                service.send_response(service.callback(request, service.srv_type.Response()), header)
            header, response = client.handle.take_response(client.srv_type.Response)
            if header is not None:
                client.get_pending_request(header.request_id.sequence_number).set_result(response)
            if time.monotonic() > end:
                raise LceError(f"an answer of {client.srv_name} did not arrive in {_PATIENCE_S:g} s")

    def _hand_over(self, reader: Subscription) -> None:
        message = reader.handle.take_message(reader.msg_type, reader.raw)
        if message is None:  # never seen with Fast DDS, which delivers within the process before publish returns
            message = self._wait_for(reader)
        if reader._callback_type is Subscription.CallbackType.MessageOnly:
            reader.callback(message[0])
        else:
            reader.callback(*message)

    def _wait_for(self, reader: Subscription) -> tuple[Any, Any]:
        end = time.monotonic() + _PATIENCE_S
        while time.monotonic() < end:
            message: tuple[Any, Any] | None = reader.handle.take_message(reader.msg_type, reader.raw)
            if message is not None:
                return message
        raise LceError(f"a message on {reader.topic_name} did not arrive in {_PATIENCE_S:g} s")

    def _wait_for_matches(self) -> None:
        end = time.monotonic() + _PATIENCE_S
        writers = [publisher for node in self._nodes for publisher in node.publishers]
        counts = Counter(writer.topic_name for writer in writers)
        readers = [reader for found in self._readers.values() for reader in found]
        # Each side finds the other by itself, and only what both have found is delivered.
        while any(w.get_subscription_count() < len(self._readers.get(w.topic_name, ())) for w in writers) or any(
            r.get_publisher_count() < counts[r.topic_name] for r in readers
        ):
            if time.monotonic() > end:
                raise LceError(f"the nodes did not find each other in {_PATIENCE_S:g} s")
            self._executor.spin_once(timeout_sec=0.01)
        for client, _ in self._calls:
            if not client.wait_for_service(_PATIENCE_S):
                raise LceError(f"service {client.srv_name} was not found in {_PATIENCE_S:g} s")
