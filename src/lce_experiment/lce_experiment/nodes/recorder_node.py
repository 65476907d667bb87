# SPDX-License-Identifier: Apache-2.0
"""Node `recorder`: writes the topics of the bench, as they come over the wire, into a rosbag2 folder (MCAP).

Subscribes  every topic of parameter `topics`, raw
Parameters  out             folder of the recording; must not exist; empty: runs/DATE-TIME
            topics          names, relative or absolute; "NAME pkg/msg/Type" for a topic that lce_data.topics lacks
            after           the recorder subscribes to laser/power_command a second after each of these topics has had
                            a message. A player that waits for the recorder then knows that everything arrives.
            flush_period_s  s, how often messages go to the operating system: the most that a kill -9 can cost
            experiment      JSON object, the beginning of experiment.yaml beside the bag. The recorder adds the versions
                            of the software; all of it also stands in custom_data of the bag's metadata.yaml

Log time and publish time of a message are the time at which its publisher sent it: a recorder that stalls shifts
nothing. On simulated time they are the node's clock. A message that was sent before the recording began, such as a
latched target, has the time of the beginning. experiment.yaml counts what was lost on the way, by topic.
"""

from __future__ import annotations

import functools
import importlib
import json
import math
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from rclpy.topic_endpoint_info import TopicEndpointInfo
from std_msgs.msg import Float64

from lce_data import experiment_file as experiment
from lce_data.bag.message_types import message_type
from lce_data.bag.writer import BagWriter
from lce_data.channels import POWER
from lce_data.errors import LceError
from lce_data.topics import COMMAND, LATCHED_TOPICS, RECORDED
from lce_experiment.plan import RUNS, new_folder
from lce_ros.health import Level
from lce_ros.node import LceNode, run
from lce_ros.qos import LATCHED_LISTENERS, deeper
from lce_ros.repeats import Repeats

_QUEUE: Final = 1000
"""Messages of a topic that the middleware keeps while this node is busy, with a slow disk for example: 10 s at 100 Hz.
For a process that stands still altogether it keeps half a thousand of all topics; the rest is lost, and counted."""
DISCOVERY_S: Final = 1.0
"""Time from the moment when every topic of ``after`` has had a message to the subscription to commands [s]. Processes
that discover each other delay each other, and once somebody commands the laser, half a second without a temperature is
a fault."""

LAST_ZERO_S: Final = 1.0
"""Longest time for which a recorder that is stopped waits until the laser has said that it is dark [s]. Ctrl-C in a
terminal stops both at once."""
_LOOK_S: Final = 0.01
SILENT_S: Final = 5.0
"""After this time the log names the topics of ``after`` that are still silent [s]."""


@dataclass(frozen=True)
class _Stream:
    """A topic as the parameter names it, its resolved name, and its type by name and as a class."""

    topic: str
    name: str
    type_name: str
    kind: Any


class Recorder(LceNode):
    """Takes raw messages and writes a rosbag2 folder."""

    reports_on = "recording"

    def __init__(self, **options: Any) -> None:
        super().__init__("recorder", **options)
        out, topics, after, about, flush_s = self._declare_parameters()
        streams = [self._stream(entry) for entry in topics]
        self._after = {self.resolve_topic_name(topic) for topic in after if topic} & {s.name for s in streams}
        self.folder = Path(out) if out else new_folder(RUNS)
        about = experiment.with_provenance(about)
        self._bag = BagWriter(self.folder, experiment.custom_data(about))
        self._about = about.with_entries(started=experiment.now())
        experiment.write(self.folder, self._about)
        self._numbers: dict[str, int] = {}
        self._lost: dict[str, int] = {}
        self._lost_told = 0
        self._last_power: bytes | None = None
        self._simulated = self.on_sim_time
        self._began_ns = self.get_clock().now().nanoseconds
        self._later = [stream for stream in streams if self._after and stream.topic == COMMAND]
        for stream in streams:
            if stream not in self._later:
                self._record(stream)
        self._complete_s = self._flushed_s = math.inf
        if self._simulated:
            self.every(flush_s, self._flush)
        else:  # a system clock that is set back would stop the timer
            self.create_timer(flush_s, self._flush, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.get_logger().info(
            f"recording {len(streams)} topics into {self.folder.absolute()}, to the disk every {flush_s:g} s"
        )

    def close(self) -> None:
        """Finish the bag once the laser is dark, with what is still in the queues."""
        if not self._about.ended:
            try:
                self._take_the_last()
            finally:
                self._finish()
        super().close()

    def _take_the_last(self) -> None:
        """Record until the laser is dark."""
        self._take_waiting()
        until_s = time.monotonic() + LAST_ZERO_S
        while self._is_lit() and time.monotonic() < until_s:
            time.sleep(_LOOK_S)
            self._take_waiting()
        self._take_waiting()  # what came before the laser was gone

    def _finish(self) -> None:
        try:
            self._bag.close()
        finally:
            self._about = self._about.with_entries(
                ended=experiment.now(),
                messages=dict(sorted(self._bag.counts.items())),
                lost=dict(sorted(self._lost.items())),
            )
            # On a full disk this may fail, too; what the bag says of it is the better line.
            with suppress(LceError) if self._bag.failed else nullcontext():
                experiment.write(self.folder, self._about)
        count, lost = sum(self._bag.counts.values()), sum(self._lost.values())
        self.get_logger().info(f"{count} messages in {self.folder.absolute()}, {lost} lost")

    def _take_waiting(self) -> None:
        """Record what is in the queues; the executor is over."""
        for reader in (reader for reader in self.subscriptions if reader.raw):
            while (waiting := reader.handle.take_message(reader.msg_type, True)) is not None:
                reader.callback(*waiting)

    def _is_lit(self) -> bool:
        """Whether the last power recorded is not zero, and a laser is there that may still say zero."""
        lit = self._last_power is not None and deserialize_message(self._last_power, Float64).data != 0.0
        return lit and self.count_publishers(POWER.topic) > 0

    def _declare_parameters(self) -> tuple[str, list[str], list[str], experiment.Experiment, float]:
        """Values of out, topics, after, experiment and flush_period_s [s]."""
        return (
            self.declare("out", "", "folder of the recording; must not exist; empty: runs/DATE-TIME", read_only=True),
            self.declare("topics", list(RECORDED), "topics to record", read_only=True),
            self.declare(
                "after",
                [""],
                "topics that must have a message before the recorder subscribes to laser/power_command",
                read_only=True,
            ),
            _experiment(self.declare("experiment", "{}", "beginning of experiment.yaml, JSON", read_only=True)),
            self.declare(
                "flush_period_s",
                0.25,
                "how often messages go to the operating system",
                unit="s",
                lower=0.01,
                upper=1.0,
                read_only=True,
            ),
        )

    def _stream(self, entry: str) -> _Stream:
        """What an entry of the parameter `topics` stands for. Raises LceError if its type is unknown."""
        topic, _, type_name = entry.strip().partition(" ")
        type_name = type_name.strip() or RECORDED.get(topic, "")
        if len(type_name.split("/")) != 3:
            raise LceError(f"recorder: topic {entry!r} has no type here; write it as 'NAME pkg/msg/Type'")
        package, _, message = message_type(type_name).name.split("/")
        try:
            kind = getattr(importlib.import_module(f"{package}.msg"), message)
        except (ImportError, AttributeError):
            raise LceError(f"recorder: message type {type_name} is not installed") from None
        return _Stream(topic, self.resolve_topic_name(topic), type_name, kind)

    def _record(self, stream: _Stream) -> None:
        self.received.setdefault(stream.name, 0)
        keep = functools.partial(self._keep, stream, Repeats())
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)  # one of LATCHED_LISTENERS may match in vain
        for qos in LATCHED_LISTENERS if stream.topic in LATCHED_TOPICS else (deeper(_QUEUE),):
            self.create_subscription(stream.kind, stream.topic, keep, qos, raw=True, event_callbacks=quiet)

    def _keep(self, stream: _Stream, repeats: Repeats, message: bytes, info: dict[str, Any]) -> None:
        if stream.topic in LATCHED_TOPICS and repeats.has(info["source_timestamp"]):
            return
        topic = stream.name
        self.received[topic] += 1
        if topic not in self._bag.counts:
            publishers = self.get_publishers_info_by_topic(topic)
            self._bag.add_topic(topic, stream.type_name, _offered(publishers))
            self._lost[topic] = 0
            self._after.discard(topic)
            if not self._after:
                self._complete_s = min(self._complete_s, self.now_s())
        sent_ns = self.get_clock().now().nanoseconds if self._simulated else info["source_timestamp"]
        self._bag.write(topic, max(sent_ns, self._began_ns), sent_ns, message)
        self._count_lost(topic, info["publication_sequence_number"])
        if stream.topic == POWER.topic:
            self._last_power = message

    def _count_lost(self, topic: str, number: int | None) -> None:
        """Count gaps in the numbers that a publisher gives its messages, on topics with one publisher.

        A middleware that gives none leaves nothing to count.
        """
        if topic not in self._lost:
            return
        if number is None:
            del self._lost[topic]
            return
        last = self._numbers.get(topic, number - 1)
        if number <= last or (number > last + 1 and self.count_publishers(topic) != 1):
            del self._lost[topic]
        elif number > last + 1:
            self._lost[topic] += number - last - 1
            self.report(Level.WARN, "messages were lost", lost=sum(self._lost.values()))
        self._numbers[topic] = number

    def _flush(self) -> None:
        self._bag.flush()
        if not self._simulated and self.get_clock().now().nanoseconds < self._began_ns:
            raise LceError("recorder: the clock was set back to before the recording began; its times end here")
        self._flushed_s = min(self._flushed_s, self.now_s())
        silent = self._after if self.now_s() - self._flushed_s > SILENT_S else ()
        if silent:
            self.report(Level.WARN, f"recording, with no message yet on {', '.join(sorted(silent))}")
        else:
            self.report(Level.OK, "recording")
        if (lost := sum(self._lost.values())) != self._lost_told:  # now, for the case that the recorder is killed
            self._lost_told = lost
            experiment.write(self.folder, self._about.with_entries(lost=dict(sorted(self._lost.items()))))
        while self._later and self.now_s() >= self._complete_s + DISCOVERY_S:
            self._record(self._later.pop())


def _offered(publishers: Sequence[TopicEndpointInfo]) -> list[dict[str, Any]]:
    profiles: list[dict[str, Any]] = []
    for publisher in publishers:
        profile = qos_entry(publisher.qos_profile)
        if profile not in profiles:
            profiles.append(profile)
    return profiles


def _experiment(text: str) -> experiment.Experiment:
    try:
        value = json.loads(text)
    except json.JSONDecodeError as error:
        raise LceError(
            f"recorder: parameter experiment is not JSON ({error}): {text!r}; "
            """conditions:= of a launch file is an object, such as '{"specimen": "A1"}'"""
        ) from None
    if not isinstance(value, dict):
        raise LceError(f"recorder: parameter experiment is {text!r}, not a JSON object")
    return experiment.experiment_of(value, "recorder: parameter experiment")


def qos_entry(profile: QoSProfile) -> dict[str, Any]:
    """A QoS profile as rosbag2 (metadata version 9) writes it."""
    return {
        "history": profile.history.name.lower(),
        "depth": profile.depth,
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "deadline": _time(profile.deadline),
        "lifespan": _time(profile.lifespan),
        "liveliness": profile.liveliness.name.lower(),
        "liveliness_lease_duration": _time(profile.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def _time(duration: Duration) -> dict[str, int]:
    sec, nsec = divmod(duration.nanoseconds, 10**9)
    return {"sec": sec, "nsec": nsec}


def main() -> int:
    """Entry point of the executable."""
    return run(Recorder)


if __name__ == "__main__":
    sys.exit(main())
