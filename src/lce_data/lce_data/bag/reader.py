# SPDX-License-Identifier: Apache-2.0
"""Read topics of numbers out of a rosbag2 folder or an MCAP file: any of them, or the channels of one experiment."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lce_data.channels import CHANNELS, INPUTS, NAMED_INPUT, NUMBER, STAMPED_NUMBER, Channel, named_input
from lce_data.errors import LceError
from lce_data.marker import Marker, decode_markers
from lce_data.schema import read_yaml
from lce_data.topics import LOG, MARKER

Floats = NDArray[np.float64]

Recorded = Mapping[Channel, tuple[Floats, Floats]]
"""Time [s] and value [recorded unit] of each channel that was recorded, (n,) each."""

METADATA: Final = "metadata.yaml"
OWN_TOPICS: Final = tuple(
    topic for channel in CHANNELS if channel not in INPUTS for topic in (channel.topic, channel.stamped_topic) if topic
)
"""Topics of an actuator and its sensors: one of them tells the namespace of a bag."""
PLAIN_TOPICS: Final = tuple(channel.topic for channel in CHANNELS)
STAMPED_TOPICS: Final = tuple(channel.stamped_topic for channel in CHANNELS if channel.stamped_topic)
NAMED_TOPIC: Final = "/input/"


@dataclass(frozen=True)
class Messages:
    """The messages of one topic in the order of the bag: their type, and log time [ns] and CDR of each."""

    type: str
    log_time_ns: list[int] = field(default_factory=list)
    cdr: list[bytes] = field(default_factory=list)

    def by_log_time(self) -> tuple[Floats, Floats]:
        """Time [s] at which each message was recorded, and its number."""
        return _seconds(self.log_time_ns), NUMBERS[self.type](self)[1]

    def by_stamp(self) -> tuple[Floats, Floats]:
        """Time [s] in the header of each message, or at which it was recorded if none has one, and its number."""
        time_ns, value = NUMBERS[self.type](self)
        return _seconds(time_ns if time_ns and any(time_ns) else self.log_time_ns), value


def read_topics(path: Path, wanted: Callable[[str, str], bool]) -> dict[str, Messages]:
    """Read the topics of a bag for which ``wanted(topic, type)``.

    Raises
    ------
    LceError
        If the bag cannot be read, or a topic has messages of two types; names the bag and what to do.
    """
    found: dict[str, Messages] = {}
    with foreign(path):
        for topic, type_name, log_time_ns, cdr in (_from_file if path.is_file() else _from_folder)(path, wanted):
            messages = found.setdefault(topic, Messages(type_name))
            if messages.type != type_name:
                raise LceError(f"{path}: topic {topic} is a {type_name}, and a {messages.type} as well")
            messages.log_time_ns.append(log_time_ns)
            messages.cdr.append(cdr)
    return found


@contextmanager
def foreign(path: Path) -> Iterator[None]:
    """A block in which other people's parsers read the bytes of a bag: what they raise, the bytes have caused.

    A damaged file leads them anywhere: an index out of range, a key that is missing, a length of terabytes. Nothing
    else belongs into the block. Raises LceError for all of it.
    """
    try:
        yield
    except LceError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise LceError(f"{path}: not a readable bag ({reason}); if it was cut short, run: lce repair {path}") from error


def read_numbers(path: Path) -> dict[str, tuple[Floats, Floats]]:
    """Log time [s] and number, (n,) each, of every topic of a bag that holds numbers.

    Raises LceError if the bag cannot be read.
    """
    found = read_topics(path, lambda _, type_name: type_name in NUMBERS)
    with foreign(path):
        return {topic: messages.by_log_time() for topic, messages in found.items()}


def read_bag(path: Path) -> Recorded:
    """Read the channels of a bag: `read_bag_with_markers` without the markers."""
    return read_bag_with_markers(path)[0]


def read_bag_with_markers(path: Path) -> tuple[Recorded, tuple[Marker, ...]]:
    """Read the channels of a bag, timed by their header stamps, or by the log time of the bag if they have none.

    The markers have the same times [s].

    A channel whose messages have no stamp is read from the stamped topic beside it, if that was recorded too.

    Raises
    ------
    LceError
        If the bag cannot be read, is empty, or holds several actuators or a channel of another type; names the bag,
        the topic, and what to do.
    """
    found = read_topics(path, lambda topic, kind: _is_channel(topic, kind) or _is_marker(topic, kind))
    own = [topic for topic in found if _ends_in(topic, OWN_TOPICS)]
    if not own:
        raise LceError(f"{path}: the bag is empty; if it was cut short, run: lce repair {path}")
    namespace = _namespace(path, own)
    recorded: dict[Channel, tuple[Floats, Floats]] = {}
    for channel in (*CHANNELS, *_named_inputs(found, namespace)):
        messages = found.get(f"{namespace}{channel.topic}")
        if messages is not None and messages.type != channel.message:
            raise LceError(f"{path}: topic {namespace}{channel.topic} is a {messages.type}, not a {channel.message}")
        if channel.stamped_topic:
            messages = found.get(f"{namespace}{channel.stamped_topic}", messages)
        if messages is None:
            continue
        with foreign(path):
            time_s, value = messages.by_stamp()
        recorded[channel] = _latest(time_s, value)
    marked = found.get(f"{namespace}{MARKER}", Messages(LOG))
    with foreign(path):
        return recorded, decode_markers(marked.log_time_ns, marked.cdr)


def _from_folder(path: Path, wanted: Callable[[str, str], bool]) -> Iterator[tuple[str, str, int, bytes]]:
    """Topic, type, log time [ns] and CDR of each message of a folder."""
    from rosbags.rosbag2 import Reader

    if (path / METADATA).exists():  # rosbags would read what a few lines of aliases make of it
        read_yaml(path / METADATA)
    with Reader(path) as reader:
        connections = [c for c in reader.connections if wanted(c.topic, c.msgtype)]
        if connections:  # rosbags takes an empty choice for all
            for connection, time_ns, data in reader.messages(connections):
                yield connection.topic, connection.msgtype, time_ns, bytes(data)


def _from_file(path: Path, wanted: Callable[[str, str], bool]) -> Iterator[tuple[str, str, int, bytes]]:
    """Topic, type, log time [ns] and CDR of each message of an MCAP file."""
    from mcap.reader import make_reader

    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if schema is not None and wanted(channel.topic, schema.name):
                yield channel.topic, schema.name, message.log_time, message.data


def _is_channel(topic: str, type_name: str) -> bool:
    """Whether a topic is that of a channel in some namespace, and not what the simulator knows of it."""
    if "/sim/" in f"/{topic}":
        return False
    if type_name == STAMPED_NUMBER:
        return _ends_in(topic, STAMPED_TOPICS)
    named = NAMED_TOPIC in f"/{topic}" and type_name == NUMBER
    return named or _ends_in(topic, PLAIN_TOPICS)


def _is_marker(topic: str, type_name: str) -> bool:
    return type_name == LOG and _ends_in(topic, (MARKER,))


def _ends_in(topic: str, names: Iterable[str]) -> bool:
    return any(f"/{topic}".endswith(f"/{name}") for name in names)


def _namespace(path: Path, topics: Iterable[str]) -> str:
    """What stands before the topics' names. Raises LceError if two actuators were recorded into one bag."""
    fronts = {topic.removesuffix(name) for topic in topics for name in OWN_TOPICS if _ends_in(topic, (name,))}
    if len(fronts) > 1:
        raise LceError(f"{path}: several actuators in one bag ({', '.join(sorted(fronts))}); record each on its own")
    return fronts.pop()


def _named_inputs(topics: Iterable[str], namespace: str) -> list[Channel]:
    """The inputs that a user named: topics ``input/NAME`` of the namespace."""
    front = f"{namespace}{NAMED_TOPIC[1:]}"
    names = sorted(NAMED_INPUT + topic.removeprefix(front) for topic in topics if topic.startswith(front))
    return [named_input(name) for name in names if name.isidentifier()]


def _floats(messages: Messages) -> tuple[None, Floats]:
    """Float64 messages: four bytes of CDR header, of which the second tells the byte order, then the number."""
    order = "<f8" if messages.cdr[0][1] & 1 else ">f8"
    return None, np.frombuffer(b"".join(cdr[4:12] for cdr in messages.cdr), dtype=order).astype(np.float64)


def _stamped_floats(messages: Messages) -> tuple[list[int], Floats]:
    """Float64Stamped messages: CDR header, seconds, nanoseconds, length and text of the frame, padding, the number."""
    time_ns, value = [], np.empty(len(messages.cdr))
    for i, cdr in enumerate(messages.cdr):
        order = "<" if cdr[1] & 1 else ">"
        sec, nanosec, length = struct.unpack_from(f"{order}iII", cdr, 4)
        end = 12 + length
        (value[i],) = struct.unpack_from(f"{order}d", cdr, 4 + end + -end % 8)
        time_ns.append(sec * 1_000_000_000 + nanosec)
    return time_ns, value


def _temperatures(messages: Messages) -> tuple[list[int], Floats]:
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    decoded: list[Any] = [store.deserialize_cdr(cdr, messages.type) for cdr in messages.cdr]
    stamps = [message.header.stamp for message in decoded]
    time_ns = [stamp.sec * 1_000_000_000 + stamp.nanosec for stamp in stamps]
    return time_ns, np.array([message.temperature for message in decoded], dtype=np.float64)


def _seconds(time_ns: list[int]) -> Floats:
    return np.array(time_ns, dtype=np.int64).astype(np.float64) * 1e-9


def _latest(time: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Of several messages at one instant (a laser shut off in the tick of its last command) the last one holds."""
    last = np.append(np.diff(time) != 0.0, True)
    return time[last], value[last]


NUMBERS: Final[Mapping[str, Callable[[Messages], tuple[list[int] | None, Floats]]]] = {
    NUMBER: _floats,
    STAMPED_NUMBER: _stamped_floats,
    "sensor_msgs/msg/Temperature": _temperatures,
}
"""How header stamps [ns], if there are any, and numbers are decoded from messages of a type."""
