# SPDX-License-Identifier: Apache-2.0
"""`metadata.yaml` of a rosbag2 folder, version 9, as ROS 2 Jazzy writes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from lce_data.files import write_atomically

FILE_NAME = "metadata.yaml"
STATE = "lce_state"
"""Key in custom_data that says whether the recording came to its end."""
RECORDING, FINISHED, REPAIRED = "recording", "finished", "repaired"


@dataclass(frozen=True)
class TopicCount:
    """A recorded topic: name, type `pkg/msg/Name`, RIHS01 hash, QoS profiles offered, number of messages."""

    name: str
    type: str
    hash: str
    qos: tuple[Mapping[str, Any], ...]
    count: int


def metadata(file: str, topics: Sequence[TopicCount], start_ns: int, end_ns: int, state: str) -> dict[str, Any]:
    """The content of rosbag2_bagfile_information for one MCAP file."""
    total = sum(topic.count for topic in topics)
    starting = {"nanoseconds_since_epoch": start_ns}
    duration = {"nanoseconds": end_ns - start_ns}
    return {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": starting,
        "message_count": total,
        "topics_with_message_count": [_topic(topic) for topic in topics],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file],
        "files": [{"path": file, "starting_time": starting, "duration": duration, "message_count": total}],
        "custom_data": {STATE: state},
        "ros_distro": "jazzy",
    }


def _topic(topic: TopicCount) -> dict[str, Any]:
    about = {
        "name": topic.name,
        "type": topic.type,
        "serialization_format": "cdr",
        "offered_qos_profiles": [dict(profile) for profile in topic.qos],
        "type_description_hash": topic.hash,
    }
    return {"topic_metadata": about, "message_count": topic.count}


def dump(value: object) -> str:
    """YAML text, keys in the order given, no anchors."""
    return yaml.dump(value, Dumper=_Plain, sort_keys=False, allow_unicode=True)


def write(folder: Path, content: Mapping[str, Any]) -> None:
    """Write metadata.yaml into a bag folder."""
    write_atomically(folder / FILE_NAME, dump({"rosbag2_bagfile_information": dict(content)}))


class _Plain(yaml.SafeDumper):
    def ignore_aliases(self, data: object) -> bool:
        return True
