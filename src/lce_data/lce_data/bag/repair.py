# SPDX-License-Identifier: Apache-2.0
"""Make a bag that a crash cut short readable by every tool: copy its whole records into a finished file."""

from __future__ import annotations

import os
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import yaml
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer
from zstandard import ZstdError

from lce_data.bag import metadata as bag_metadata
from lce_data.bag.message_types import message_type
from lce_data.bag.metadata import FINISHED, REPAIRED, STATE, TopicCount
from lce_data.bag.writer import LIBRARY
from lce_data.errors import LceError

_RECORD_HEAD = struct.Struct("<BQ")
_DATA_END = 0x0F


@dataclass(frozen=True)
class Repair:
    """What was done to a bag: messages kept, seconds they span, bytes that could not be used.

    `original` is where the damaged file was put; None where nothing had to be done.
    """

    path: Path
    messages: int
    duration_s: float
    lost_bytes: int
    original: Path | None


def repair(bag: Path) -> Repair:
    """Repair a bag folder or a single .mcap file in place, keeping the damaged file under another name.

    A bag that is whole is left alone. Raises LceError, with nothing changed, where there is nothing to keep.
    """
    folder, file = _find(bag)
    whole = _read_whole(file)
    if whole is not None and (folder is None or _is_finished(folder)):
        return Repair(bag, *whole, 0, None)
    part = file.with_name(file.name + ".repair")
    original = file.with_name(file.name + ".truncated")
    if original.exists():
        raise LceError(f"{original}: exists already, so {file.name} was repaired before; move it away first")
    try:
        topics, start_ns, end_ns, lost = _copy(file, part)
        content = bag_metadata.metadata(file.name, topics, start_ns, end_ns, REPAIRED)
        _keep(file, original)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
    if folder is not None:
        bag_metadata.write(folder, content)
    return Repair(bag, content["message_count"], (end_ns - start_ns) / 1e9, lost, original)


def _keep(file: Path, original: Path) -> None:
    """Give the damaged file a second name (without hard links: another name, for a moment the only one)."""
    try:
        os.link(file, original)
    except OSError:
        file.rename(original)


def _find(bag: Path) -> tuple[Path | None, Path]:
    if bag.is_dir():
        files = sorted(bag.glob("*.mcap"))
        if len(files) != 1:
            raise LceError(f"{bag}: holds {len(files)} .mcap files, not one")
        return bag, files[0]
    if not bag.is_file():
        raise LceError(f"{bag}: no such bag")
    folder = bag.parent if (bag.parent / bag_metadata.FILE_NAME).is_file() else None
    return folder, bag


def _is_finished(folder: Path) -> bool:
    """Whether metadata.yaml is there and does not say that the recording was still going on."""
    try:
        content = yaml.safe_load((folder / bag_metadata.FILE_NAME).read_text(encoding="utf-8"))
        custom = content["rosbag2_bagfile_information"]["custom_data"] or {}
        return custom.get(STATE, FINISHED) in (FINISHED, REPAIRED)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, AttributeError):
        return False


def _read_whole(file: Path) -> tuple[int, float] | None:
    """(messages, seconds) of a finished MCAP file, None for any other."""
    try:
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
    except (McapError, OSError, ValueError, struct.error):
        return None
    if summary is None or summary.statistics is None:
        return None
    found = summary.statistics
    return found.message_count, (found.message_end_time - found.message_start_time) / 1e9


def _copy(file: Path, part: Path) -> tuple[list[TopicCount], int, int, int]:
    """Copy the whole records of `file` into a finished `part`: (topics, first ns, last ns, bytes unused)."""
    schemas: dict[int, tuple[int, str]] = {}
    channels: dict[int, tuple[int, Channel, str]] = {}
    counts: Counter[int] = Counter()
    times = [0, 0]
    with file.open("rb") as source, part.open("wb") as target:
        end = _whole_records(file, source)
        lost = source.seek(0, os.SEEK_END) - end
        writer: Any = Writer(target, compression=CompressionType.NONE)
        writer.start(profile="ros2", library=LIBRARY)
        for record in _records(source, end):
            if isinstance(record, Chunk):  # one that cannot be unpacked
                lost += len(record.data)
            elif isinstance(record, Schema) and record.id not in schemas:
                made = writer.register_schema(record.name, record.encoding, record.data)
                schemas[record.id] = made, record.name
            elif isinstance(record, Channel) and record.id not in channels:
                schema, type_name = schemas.get(record.schema_id, (0, ""))
                made = writer.register_channel(record.topic, record.message_encoding, schema, record.metadata)
                channels[record.id] = made, record, type_name
            elif isinstance(record, Message) and record.channel_id in channels:
                writer.add_message(
                    channels[record.channel_id][0],
                    record.log_time,
                    record.data,
                    record.publish_time,
                    record.sequence,
                )
                times = (
                    [min(times[0], record.log_time), max(times[1], record.log_time)]
                    if counts
                    else [record.log_time] * 2
                )
                counts[record.channel_id] += 1
        if not counts:
            raise LceError(f"{file}: no whole message in it; there is nothing to repair")
        writer.finish()
        target.flush()
        os.fsync(target.fileno())
    topics = [_topic(channel, type_name, counts[k]) for k, (_, channel, type_name) in channels.items()]
    return sorted(topics, key=lambda topic: topic.name), times[0], times[1], lost


class _Beginning:
    """The first `size` bytes of a file, as a stream of its own."""

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream, self._left = stream, size
        stream.seek(0)

    def read(self, size: int) -> bytes:
        data = self._stream.read(min(size, self._left))
        self._left -= len(data)
        return data


def _records(stream: BinaryIO, end: int) -> Iterator[McapRecord]:
    """Records before `end`, chunks unpacked; a chunk that is damaged comes as it is."""
    reader = StreamReader(_Beginning(stream, end), emit_chunks=True, record_size_limit=None)  # type: ignore[arg-type]
    try:
        for record in reader.records:
            if isinstance(record, Chunk):
                yield from _unpack(record)
            else:
                yield record
    except (McapError, ValueError, struct.error):  # EndOfFile, or bytes that are no record
        return


def _unpack(chunk: Chunk) -> list[McapRecord]:
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except (McapError, ValueError, struct.error, RuntimeError, ZstdError):
        return [chunk]


def _topic(channel: Channel, type_name: str, count: int) -> TopicCount:
    qos = yaml.safe_load(channel.metadata.get("offered_qos_profiles", "")) or ()
    try:
        digest = message_type(type_name).hash
    except (LceError, ValueError):  # a type that is not installed here: readers do not need the hash
        digest = ""
    return TopicCount(channel.topic, type_name, digest, tuple(qos), count)


def _whole_records(file: Path, stream: BinaryIO) -> int:
    """Offset behind the last whole record of the data section; to mcap's reader a short one is whole."""
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise LceError(f"{file}: not an MCAP file")
    offset = len(MCAP0_MAGIC)
    while offset + _RECORD_HEAD.size <= size:
        stream.seek(offset)
        opcode, length = _RECORD_HEAD.unpack(stream.read(_RECORD_HEAD.size))
        if opcode == _DATA_END or opcode == 0 or offset + _RECORD_HEAD.size + length > size:
            break
        offset += _RECORD_HEAD.size + length
    return offset
