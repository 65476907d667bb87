# SPDX-License-Identifier: Apache-2.0
"""Write a rosbag2 folder with MCAP storage; a crash loses only the messages since the last flush.

`flush` sorts the messages received since the last one by (log time, topic) and writes them as one chunk. In lockstep
the same messages therefore give the same file, whatever order the callbacks ran in.
"""

from __future__ import annotations

import errno
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from operator import itemgetter
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from mcap.writer import CompressionType, Writer

from lce_data import __version__
from lce_data.bag import metadata as bag_metadata
from lce_data.bag.message_types import MessageType, message_type
from lce_data.bag.metadata import FINISHED, RECORDING, BagMetadata, topic_count
from lce_data.errors import LceError
from lce_data.yaml_text import dump

LIBRARY = f"lce {__version__}"
FILE_NAME = "recording.mcap"
"""The same in every folder, so that the same run is the same file, byte for byte."""
_CHUNK_BYTES = 1 << 20
FULL: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What the operating system says when there is no more room for a file."""


class BagWriter:
    """One recording. `folder` must not exist; it gets a metadata.yaml at once, which says "recording".

    ``about`` is text by key for the custom_data of the metadata: specimen, notes, versions.

    ``counts`` are the messages written by topic; ``failed`` says whether the file could not be written.

    Raises LceError if the folder exists or cannot be made, or a message type is not installed. Later it does when the
    file cannot be written any more: that closes the recording, and what the last flush wrote can be repaired.
    """

    def __init__(self, folder: Path, about: Mapping[str, str] = MappingProxyType({})) -> None:
        self.folder, self._about = folder, dict(about)
        try:
            folder.mkdir(parents=True)
            self.file = folder / FILE_NAME
            self._stream = self.file.open("xb")
            self._writer: Any = Writer(self._stream, chunk_size=_CHUNK_BYTES, compression=CompressionType.NONE)
            self._writer.start(profile="ros2", library=LIBRARY)
            self._stream.flush()
        except FileExistsError:
            raise LceError(f"{folder}: exists already; a recording is never overwritten") from None
        except OSError as error:
            raise LceError(f"{folder}: {error.strerror}") from None
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, tuple[int, MessageType, tuple[Mapping[str, Any], ...]]] = {}
        self._waiting: list[tuple[int, str, int, bytes]] = []
        self.counts: dict[str, int] = {}
        self.failed = False
        self.start_ns = self.end_ns = 0
        bag_metadata.write(folder, self._metadata(RECORDING))

    def add_topic(self, name: str, type_name: str, qos: Sequence[Mapping[str, Any]]) -> None:
        """Announce a topic before its first message, with the QoS profiles its publishers offer."""
        kind = message_type(type_name)
        if type_name not in self._schemas:
            definition = kind.definition.encode()
            self._schemas[type_name] = self._writer.register_schema(type_name, "ros2msg", definition)
        about = {"offered_qos_profiles": dump([dict(profile) for profile in qos]).strip()}
        channel = self._writer.register_channel(name, "cdr", self._schemas[type_name], about)
        self._channels[name] = channel, kind, tuple(qos)
        self.counts[name] = 0

    def write(self, topic: str, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Take one serialised message of an announced topic; the next flush hands it to the operating system."""
        self._waiting.append((log_ns, topic, publish_ns, data))

    def flush(self) -> None:
        """Hand everything received so far to the operating system, where a killed process cannot lose it."""
        if not self._waiting or self._stream.closed:
            return
        self._waiting.sort(key=itemgetter(0, 1))
        earliest = self._waiting[0][0]  # a topic whose messages waited may have earlier ones than the last flush
        self.start_ns = min(self.start_ns, earliest) if any(self.counts.values()) else earliest
        with self._writing():
            for log_ns, topic, publish_ns, data in self._waiting:
                self.counts[topic] += 1
                self._writer.add_message(self._channels[topic][0], log_ns, data, publish_ns, self.counts[topic])
                self.end_ns = max(self.end_ns, log_ns)
            self._waiting.clear()
            self._writer.flush()

    def close(self) -> None:
        """Finish the file with its index and the folder with its metadata. A second call does nothing."""
        if self._stream.closed:
            return
        self.flush()
        content = self._metadata(FINISHED)
        with self._writing():
            self._writer.add_metadata("rosbag2", {"serialized_metadata": content.as_yaml()})
            self._writer.finish()
            self._stream.close()
        bag_metadata.write(self.folder, content)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Make an error of the file one line that says what is left."""
        try:
            yield
        except OSError as error:
            self.failed = True
            self._stream.raw.close()  # the stream itself would try to write once more
            left = f"lce repair {self.folder} makes readable what was recorded until then"
            raise LceError(f"{self.file}: cannot be written ({error.strerror}); {left}") from None

    def _metadata(self, state: str) -> BagMetadata:
        topics = [
            topic_count(name, kind.name, kind.hash, qos, self.counts[name])
            for name, (_, kind, qos) in sorted(self._channels.items())
        ]
        return bag_metadata.metadata(self.file.name, topics, self.start_ns, self.end_ns, state, self._about)
