# SPDX-License-Identifier: Apache-2.0
"""The series of one experiment out of a rosbag2 folder or an MCAP file."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Final

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from numpy.typing import NDArray
from rosbags.rosbag2 import Reader, ReaderError
from rosbags.typesys import Stores, get_typestore

from lce_data.channels import CHANNELS, Channel
from lce_data.errors import LceError

Floats = NDArray[np.float64]
Message = tuple[str, str, int, bytes]
"""Topic, type, log time [ns], CDR."""

Recorded = Mapping[Channel, tuple[Floats, Floats]]
"""Time [s] and value [recorded unit] of each channel that was recorded."""

TOPICS: Final = {channel.topic: channel for channel in CHANNELS}


def read_bag(path: Path) -> Recorded:
    """Read the channels of a bag; LceError names the bag, the topic, and what to do.

    ``temperature`` is timed by its header stamp, the plain Float64 topics by the log time of the bag.
    """
    try:
        messages = list(_from_file(path) if path.is_file() else _from_folder(path))
    except (ReaderError, McapError, OSError, UnicodeDecodeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise LceError(f"{path}: not a readable bag ({reason}); if it was cut short, run: lce repair {path}") from None
    if not messages:
        raise LceError(f"{path}: the bag is empty; if it was cut short, run: lce repair {path}")
    namespace = _namespace(path, {topic for topic, *_ in messages})
    found: dict[str, list[Message]] = {name: [] for name in TOPICS}
    for message in messages:
        name = message[0].removeprefix(namespace)
        if name in TOPICS and message[0].startswith(namespace):
            wanted = TOPICS[name].message
            if message[1] != wanted:
                raise LceError(f"{path}: topic {message[0]} is a {message[1]}, not a {wanted}")
            found[name].append(message)
    return {TOPICS[name]: READERS[TOPICS[name].message](messages) for name, messages in found.items() if messages}


def _from_folder(path: Path) -> Iterator[Message]:
    with Reader(path) as reader:
        wanted = [c for c in reader.connections if _relevant(c.topic)]
        if not wanted:
            return
        for connection, time_ns, data in reader.messages(wanted):
            yield connection.topic, connection.msgtype, time_ns, bytes(data)


def _from_file(path: Path) -> Iterator[Message]:
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            if schema is not None and _relevant(channel.topic):
                yield channel.topic, schema.name, message.log_time, message.data


def _relevant(topic: str) -> bool:
    return any(topic == name or topic.endswith(f"/{name}") for name in TOPICS) and "/sim/" not in f"/{topic}"


def _namespace(path: Path, topics: Iterable[str]) -> str:
    """What stands before the topic names; LceError where two actuators were recorded into one bag."""
    fronts = {topic.removesuffix(name) for topic in topics for name in TOPICS if f"/{topic}".endswith(f"/{name}")}
    if len(fronts) > 1:
        raise LceError(f"{path}: several actuators in one bag ({', '.join(sorted(fronts))}); record each on its own")
    return fronts.pop()


def _floats(messages: list[Message]) -> tuple[Floats, Floats]:
    """Float64 messages: four bytes of CDR header, of which the second tells the byte order, then the number."""
    order = "<f8" if messages[0][3][1] & 1 else ">f8"
    value = np.frombuffer(b"".join(m[3][4:12] for m in messages), dtype=order).astype(np.float64)
    return _latest(_seconds([m[2] for m in messages]), value)


def _temperatures(messages: list[Message]) -> tuple[Floats, Floats]:
    store = get_typestore(Stores.ROS2_JAZZY)
    decoded = [store.deserialize_cdr(m[3], m[1]) for m in messages]
    stamp = [m.header.stamp for m in decoded]  # type: ignore[attr-defined]
    time = _seconds([s.sec * 1_000_000_000 + s.nanosec for s in stamp])
    return _latest(time, np.array([m.temperature for m in decoded], dtype=np.float64))  # type: ignore[attr-defined]


def _seconds(time_ns: list[int]) -> Floats:
    return np.array(time_ns, dtype=np.int64).astype(np.float64) * 1e-9


def _latest(time: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Of several messages at one instant (a laser shut off in the tick of its last command) the last one holds."""
    last = np.append(np.diff(time) != 0.0, True)
    return time[last], value[last]


READERS: Final[Mapping[str, Callable[[list[Message]], tuple[Floats, Floats]]]] = {
    "std_msgs/msg/Float64": _floats,
    "sensor_msgs/msg/Temperature": _temperatures,
}
"""How a series is read from messages of a type."""
