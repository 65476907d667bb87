# SPDX-License-Identifier: Apache-2.0
"""Repair a bag that a crash cut short: copy its whole records into a finished file, which every tool reads."""

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
from lce_data.bag.metadata import REPAIRED, STATE, TopicCount, topic_count
from lce_data.bag.writer import FULL, LIBRARY
from lce_data.errors import LceError
from lce_data.files import check_regular

_RECORD_HEAD = struct.Struct("<BQ")
_DATA_END = 0x0F


@dataclass(frozen=True)
class Repair:
    """What was done to a bag: messages kept, seconds they span, bytes that could not be used.

    `original` is where the damaged file was put, None if the bag was whole.
    """

    path: Path
    messages: int
    duration_s: float
    lost_bytes: int
    original: Path | None


def repair(bag: Path) -> Repair:
    """Repair a bag folder or a single .mcap file in place, keeping the damaged file under another name.

    A whole bag is left alone. Raises LceError, and changes nothing, if the file holds no whole message.
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
        content = bag_metadata.metadata(file.name, topics, start_ns, end_ns, REPAIRED, _about(folder))
        if folder is not None:  # before the file: both or, on a full disk, neither
            bag_metadata.write(folder, content)
        _keep(file, original)
        part.replace(file)
    except OSError as error:
        needs = "; a repair needs as much space as the bag takes" if error.errno in FULL else ""
        raise LceError(f"{error.filename or part}: {error.strerror}{needs}; nothing was changed") from None
    finally:
        part.unlink(missing_ok=True)
    return Repair(bag, content.message_count, (end_ns - start_ns) / 1e9, lost, original)


def _about(folder: Path | None) -> dict[str, str]:
    """What the metadata of the damaged bag said of it: specimen, notes, versions; nothing if it cannot be read."""
    try:
        found = bag_metadata.read(folder).custom_data if folder is not None else None
    except LceError:
        return {}
    return {key: str(value) for key, value in (found or {}).items() if key != STATE}


def _keep(file: Path, original: Path) -> None:
    """Give the damaged file a second name. Without hard links it is renamed, and for a moment the bag has no file."""
    try:
        os.link(file, original)
    except OSError:
        file.rename(original)


def _find(bag: Path) -> tuple[Path | None, Path]:
    if bag.is_dir():
        files = sorted(bag.glob("*.mcap"))
        if len(files) != 1:
            raise LceError(f"{bag}: holds {len(files)} .mcap files, not one")
        check_regular(files[0])
        return bag, files[0]
    if not bag.is_file():
        raise LceError(f"{bag}: no such bag")
    folder = bag.parent if (bag.parent / bag_metadata.FILE_NAME).is_file() else None
    return folder, bag


def _is_finished(folder: Path) -> bool:
    """Whether metadata.yaml can be read and does not say that the recording was still going on."""
    try:
        return bag_metadata.read(folder).is_finished
    except LceError:
        return False


def _read_whole(file: Path) -> tuple[int, float] | None:
    """Messages and seconds of a finished MCAP file, None if it is not finished."""
    try:
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
    except (McapError, OSError, ValueError, struct.error):
        return None
    if summary is None or summary.statistics is None:
        return None
    found = summary.statistics
    return found.message_count, (found.message_end_time - found.message_start_time) / 1e9


class _Copy:
    """A finished MCAP file in the making, out of records of another one."""

    def __init__(self, target: BinaryIO) -> None:
        self._writer: Any = Writer(target, compression=CompressionType.NONE)
        self._writer.start(profile="ros2", library=LIBRARY)
        self._schemas: dict[int, tuple[int, str]] = {}
        self._channels: dict[int, tuple[int, Channel, str]] = {}
        self._counts: Counter[int] = Counter()
        self.start_ns = self.end_ns = 0
        self.lost = 0

    def add(self, record: McapRecord) -> None:
        """Copy a record; of a chunk that could not be unpacked the size is added to ``lost``."""
        if isinstance(record, Chunk):
            self.lost += len(record.data)
        elif isinstance(record, Schema) and record.id not in self._schemas:
            made = self._writer.register_schema(record.name, record.encoding, record.data)
            self._schemas[record.id] = made, record.name
        elif isinstance(record, Channel) and record.id not in self._channels:
            schema, type_name = self._schemas.get(record.schema_id, (0, ""))
            made = self._writer.register_channel(record.topic, record.message_encoding, schema, record.metadata)
            self._channels[record.id] = made, record, type_name
        elif isinstance(record, Message) and record.channel_id in self._channels:
            self._add_message(record)

    def finish(self) -> list[TopicCount]:
        """Write the index of the file. Returns the topics by name, none if there was no message."""
        if self._counts:
            self._writer.finish()
        topics = [_topic(channel, kind, self._counts[k]) for k, (_, channel, kind) in self._channels.items()]
        return sorted(topics, key=lambda topic: topic.topic_metadata.name) if self._counts else []

    def _add_message(self, record: Message) -> None:
        made = self._channels[record.channel_id][0]
        self._writer.add_message(made, record.log_time, record.data, record.publish_time, record.sequence)
        self.start_ns = min(self.start_ns, record.log_time) if self._counts else record.log_time
        self.end_ns = max(self.end_ns, record.log_time)
        self._counts[record.channel_id] += 1


def _copy(file: Path, part: Path) -> tuple[list[TopicCount], int, int, int]:
    """Copy the whole records of `file` into a finished `part`: (topics, first ns, last ns, bytes unused)."""
    with file.open("rb") as source, part.open("wb") as target:
        end = _whole_records(file, source)
        unread = source.seek(0, os.SEEK_END) - end
        copy = _Copy(target)
        for record in _records(source, end):
            copy.add(record)
        topics = copy.finish()
        if not topics:
            raise LceError(f"{file}: no whole message in it; there is nothing to repair")
        target.flush()
        os.fsync(target.fileno())
    return topics, copy.start_ns, copy.end_ns, unread + copy.lost


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
    """Records before the offset `end`, chunks unpacked; a damaged chunk is yielded as it is."""
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
    except (LceError, ValueError):  # an unknown type: readers do not need the hash
        digest = ""
    return topic_count(channel.topic, type_name, digest, qos, count)


def _whole_records(file: Path, stream: BinaryIO) -> int:
    """Offset behind the last whole record of the data section. (mcap's own reader takes a short record for whole.)"""
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
