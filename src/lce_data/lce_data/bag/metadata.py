# SPDX-License-Identifier: Apache-2.0
"""`metadata.yaml` of a rosbag2 folder: version 9 is written, as ROS 2 Jazzy writes it; older ones are read too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import msgspec
from msgspec import Struct

from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.schema import checked, read_yaml
from lce_data.yaml_text import dump

FILE_NAME: Final = "metadata.yaml"
STATE: Final = "lce_state"
"""Key in custom_data that says whether the recording came to its end."""
RECORDING: Final = "recording"
FINISHED: Final = "finished"
REPAIRED: Final = "repaired"


class Duration(Struct, frozen=True):
    """A time span."""

    nanoseconds: int


class StartingTime(Struct, frozen=True):
    """The log time of the first message."""

    nanoseconds_since_epoch: int


class Topic(Struct, frozen=True):
    """A recorded topic: type `pkg/msg/Name`, QoS profiles offered (text in older versions), RIHS01 hash."""

    name: str
    type: str
    serialization_format: str
    offered_qos_profiles: list[dict[str, Any]] | str = ""
    type_description_hash: str = ""


class TopicCount(Struct, frozen=True):
    """A recorded topic and the number of its messages."""

    topic_metadata: Topic
    message_count: int


class BagFile(Struct, frozen=True):
    """A file of the bag."""

    path: str
    starting_time: StartingTime
    duration: Duration
    message_count: int


class BagMetadata(Struct, frozen=True):
    """The content of the file below its key rosbag2_bagfile_information."""

    version: int
    storage_identifier: str
    duration: Duration
    starting_time: StartingTime
    message_count: int
    topics_with_message_count: list[TopicCount]
    compression_format: str = ""
    compression_mode: str = ""
    relative_file_paths: list[str] = []
    files: list[BagFile] = []
    custom_data: dict[str, Any] | None = None
    ros_distro: str = ""

    @property
    def is_finished(self) -> bool:
        """Whether the recording came to its end. A bag of another recorder, which does not say, counts as finished."""
        return (self.custom_data or {}).get(STATE, FINISHED) in (FINISHED, REPAIRED)

    def as_yaml(self) -> str:
        """The text that rosbag2 keeps inside the MCAP file."""
        return dump(msgspec.to_builtins(self))


class _File(Struct, frozen=True):
    rosbag2_bagfile_information: BagMetadata


def topic_count(name: str, type_name: str, type_hash: str, qos: Sequence[Mapping[str, Any]], count: int) -> TopicCount:
    """Describe a topic whose messages are CDR."""
    return TopicCount(Topic(name, type_name, "cdr", [dict(profile) for profile in qos], type_hash), count)


def metadata(
    file: str,
    topics: Sequence[TopicCount],
    start_ns: int,
    end_ns: int,
    state: str,
    about: Mapping[str, str] = MappingProxyType({}),
) -> BagMetadata:
    """Describe a bag of one MCAP file; ``about`` is what custom_data says of it beside its state."""
    total = sum(topic.message_count for topic in topics)
    starting, duration = StartingTime(start_ns), Duration(end_ns - start_ns)
    return BagMetadata(
        version=9,
        storage_identifier="mcap",
        duration=duration,
        starting_time=starting,
        message_count=total,
        topics_with_message_count=list(topics),
        relative_file_paths=[file],
        files=[BagFile(file, starting, duration, total)],
        custom_data={STATE: state, **about},
        ros_distro="jazzy",
    )


def read(folder: Path) -> BagMetadata:
    """Read metadata.yaml of a bag folder. Raises LceError naming the file, the key and the value."""
    path = folder / FILE_NAME
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise LceError(f"{path}: the content is not keys with values")
    return checked(path, content, _File).rosbag2_bagfile_information


def write(folder: Path, content: BagMetadata) -> None:
    """Write metadata.yaml into a bag folder."""
    write_atomically(folder / FILE_NAME, dump(msgspec.to_builtins(_File(content))))
