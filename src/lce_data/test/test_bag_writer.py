# SPDX-License-Identifier: Apache-2.0
"""Bags: any reader takes them, arrival does not order them, and what a crash leaves can be repaired."""

import resource
import struct
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from lce_data.bag import message_types
from lce_data.bag import metadata as bag_metadata
from lce_data.bag.message_types import message_type
from lce_data.bag.repair import repair
from lce_data.bag.writer import BagWriter
from lce_data.errors import LceError
from lce_data.topics import RECORDED

POWER, DISPLACEMENT = "/lce/laser/power", "/lce/displacement"
FOREVER = {"sec": 9223372036, "nsec": 854775807}
QOS: dict[str, Any] = {
    "history": "keep_last",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": FOREVER,
    "lifespan": FOREVER,
    "liveliness": "automatic",
    "liveliness_lease_duration": FOREVER,
    "avoid_ros_namespace_conventions": False,
}


def _float64(value: float) -> bytes:
    return b"\x00\x01\x00\x00" + struct.pack("<d", value)


def _record(folder: Path, seconds: float, topics: tuple[str, ...] = (POWER, DISPLACEMENT)) -> BagWriter:
    """A recording of 100 Hz topics, flushed every 0.25 s, left open."""
    writer = BagWriter(folder)
    for topic in (POWER, DISPLACEMENT):
        writer.add_topic(topic, "std_msgs/msg/Float64", [QOS])
    for k in range(round(seconds * 100)):
        for topic in topics:
            writer.write(topic, 10**9 + k * 10**7, 10**9 + k * 10**7 - 1000, _float64(k))
        if k % 25 == 24:
            writer.flush()
    return writer


def _crashed(folder: Path, seconds: float) -> Path:
    """The file of a recording whose process died after the last flush."""
    writer = _record(folder, seconds)
    left = {path: path.read_bytes() for path in folder.iterdir()}
    writer.close()
    for path, content in left.items():
        path.write_bytes(content)
    return writer.file


def _messages(folder: Path) -> list[tuple[str, int, bytes]]:
    with AnyReader([folder]) as reader:
        return [(c.topic, t, bytes(data)) for c, t, data in reader.messages()]


def test_rosbags_reads_topics_types_hashes_and_quality_of_service(tmp_path: Path) -> None:
    _record(tmp_path / "bag", 1.0).close()
    store = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([tmp_path / "bag"]) as reader:
        assert {c.topic for c in reader.connections} == {POWER, DISPLACEMENT}
        connection = reader.connections[0]
        assert connection.digest == store.hash_rihs01("std_msgs/msg/Float64")
        assert connection.ext.offered_qos_profiles[0].depth == 10
        values = [reader.deserialize(data, c.msgtype).data for c, _, data in reader.messages([connection])]
        assert reader.duration == 990_000_001
    assert values == [float(k) for k in range(100)]


def test_mcap_carries_the_definitions_and_rosbag2_metadata(tmp_path: Path) -> None:
    writer = _record(tmp_path / "bag", 1.0)
    writer.close()
    with writer.file.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        assert reader.get_header().profile == "ros2"
        assert summary.statistics.message_count == 200
        assert [s.encoding for s in summary.schemas.values()] == ["ros2msg"]
        assert b"float64 data" in summary.schemas[1].data
        times = [(m.log_time, m.publish_time) for _, _, m in reader.iter_messages()]
        assert times[0] == (10**9, 10**9 - 1000)
        inside = yaml.safe_load(next(iter(reader.iter_metadata())).metadata["serialized_metadata"])
    beside = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert inside == beside
    assert (
        beside["version"] == 9
        and beside["message_count"] == 200
        and beside["relative_file_paths"] == ["recording.mcap"]
    )


@contextmanager
def _no_room_beyond(size: int) -> Iterator[None]:
    """No file grows beyond ``size`` bytes, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_ends_the_recording_with_one_line_and_what_was_written_can_be_repaired(tmp_path: Path) -> None:
    writer = _record(tmp_path / "bag", 1.0)
    for k in range(1000):
        writer.write(POWER, 2 * 10**9 + k * 10**7, 2 * 10**9, _float64(k))
    said = r"recording\.mcap: cannot be written \(File too large\); lce repair .* makes readable"
    with _no_room_beyond(20_000), pytest.raises(LceError, match=said):
        writer.flush()
    assert writer.failed
    writer.flush()
    writer.close()
    repaired = repair(tmp_path / "bag")
    assert repaired.messages == 200 and len(_messages(tmp_path / "bag")) == 200


def test_an_index_for_which_there_is_no_room_is_the_same_line(tmp_path: Path) -> None:
    writer = _record(tmp_path / "bag", 1.0)
    with _no_room_beyond(writer.file.stat().st_size), pytest.raises(LceError, match="cannot be written"):
        writer.close()
    assert repair(tmp_path / "bag").messages == 200


def test_a_repair_on_a_full_disk_changes_nothing_and_says_so(tmp_path: Path) -> None:
    file = _crashed(tmp_path / "bag", 3.0)
    before = {path.name: path.read_bytes() for path in (tmp_path / "bag").iterdir()}
    said = (
        r"recording\.mcap\.repair: File too large; a repair needs as much space as the bag takes; nothing was changed"
    )
    with _no_room_beyond(file.stat().st_size // 2), pytest.raises(LceError, match=said):
        repair(tmp_path / "bag")
    assert {path.name: path.read_bytes() for path in (tmp_path / "bag").iterdir()} == before
    assert repair(tmp_path / "bag").messages == 600


RECORDED_TYPES = sorted(set(RECORDED.values()))


@pytest.fixture
def no_ros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine without a ROS prefix, and nothing looked up before."""
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    for looked_up in (message_type, message_types._store):
        looked_up.cache_clear()
    yield
    for looked_up in (message_type, message_types._store):
        looked_up.cache_clear()


@pytest.mark.parametrize("name", RECORDED_TYPES)
def test_types_are_our_own_or_those_of_jazzy_with_and_without_a_ros_prefix(
    name: str, request: pytest.FixtureRequest
) -> None:
    installed = message_type(name)
    request.getfixturevalue("no_ros")
    bundled = message_type(name)
    assert installed is not bundled and installed == bundled
    if name in message_types.OWN:
        return
    jazzy = get_typestore(Stores.ROS2_JAZZY)
    assert bundled.hash == jazzy.hash_rihs01(name)
    assert bundled.definition == jazzy.generate_msgdef(name, ros_version=2)[0]


@pytest.mark.parametrize("name", ["sensor_msgs/msg/Temperature", "diagnostic_msgs/msg/DiagnosticArray"])
def test_definitions_hold_everything_a_reader_needs(name: str) -> None:
    from rosbags.typesys import get_types_from_msg

    kind = message_type(name)
    store = get_typestore(Stores.EMPTY)
    parts = kind.definition.split("=" * 80 + "\nMSG: ")
    store.register(get_types_from_msg(parts[0], name))
    for part in parts[1:]:
        part_name, _, text = part.partition("\n")
        store.register(get_types_from_msg(text, part_name.replace("/", "/msg/")))
    assert kind.hash == get_typestore(Stores.ROS2_JAZZY).hash_rihs01(name) == store.hash_rihs01(name)


def test_a_message_type_of_another_package_is_looked_up_in_the_prefix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "share" / "grip_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Force.msg").write_text("std_msgs/Header header  # when\nFinger[<=2] fingers\nfloat64 BIG=1e3\n")
    (folder / "Finger.msg").write_text("float64 newton\n")
    (folder / "Odd.msg").write_text("float64 [\n")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    kind = message_type("grip_msgs/msg/Force")
    parts = [line for line in kind.definition.splitlines() if line.startswith("MSG: ")]
    assert parts == ["MSG: std_msgs/Header", "MSG: builtin_interfaces/Time", "MSG: grip_msgs/Finger"]
    assert kind.hash.startswith("RIHS01_")
    with pytest.raises(LceError, match=r"Odd\.msg: "):
        message_type("grip_msgs/msg/Odd")


def test_a_message_type_that_is_not_installed_is_named() -> None:
    with pytest.raises(LceError, match="std_msgs/msg/Nothing is not installed"):
        message_type("std_msgs/msg/Nothing")


def test_the_file_does_not_depend_on_the_order_of_arrival(tmp_path: Path) -> None:
    first = _record(tmp_path / "a" / "bag", 2.0)
    second = _record(tmp_path / "b" / "bag", 2.0, (DISPLACEMENT, POWER))
    first.close()
    second.close()
    assert first.file.read_bytes() == second.file.read_bytes()


def test_nothing_is_ever_overwritten(tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    with pytest.raises(LceError, match="exists already"):
        BagWriter(tmp_path / "bag")
    assert list((tmp_path / "bag").iterdir()) == []


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(LceError, match="file"):
        BagWriter(tmp_path / "file" / "bag")


def test_a_recording_under_way_can_be_recognised(tmp_path: Path) -> None:
    _crashed(tmp_path / "bag", 0.5)
    content = yaml.safe_load((tmp_path / "bag" / bag_metadata.FILE_NAME).read_text())
    assert content["rosbag2_bagfile_information"]["custom_data"] == {"lce_state": "recording"}


def test_an_unfinished_bag_is_repaired_to_the_last_flush(tmp_path: Path) -> None:
    damaged = _crashed(tmp_path / "bag", 2.0).read_bytes()
    done = repair(tmp_path / "bag")
    assert (done.messages, done.lost_bytes) == (400, 0)
    assert done.original is not None and done.original.read_bytes() == damaged
    assert len(_messages(tmp_path / "bag")) == 400
    assert repair(tmp_path / "bag").original is None


@pytest.mark.parametrize("cut", [1, 7, 100, 3000, 20000])
def test_a_bag_cut_anywhere_keeps_its_whole_chunks(tmp_path: Path, cut: int) -> None:
    _record(tmp_path / "whole" / "bag", 4.0).close()
    file = _crashed(tmp_path / "bag", 4.0)
    file.write_bytes(file.read_bytes()[:-cut])
    done = repair(tmp_path / "bag")
    kept = _messages(tmp_path / "bag")
    assert kept == _messages(tmp_path / "whole" / "bag")[: len(kept)]
    assert 0 < len(kept) == done.messages and len(kept) % 50 == 0


def test_zeros_at_the_end_and_a_damaged_chunk_are_left_out(tmp_path: Path) -> None:
    file = _crashed(tmp_path / "bag", 2.0)
    data = bytearray(file.read_bytes())
    data[data.index(_float64(60.0)) + 4] ^= 0xFF
    file.write_bytes(bytes(data) + bytes(512))
    done = repair(tmp_path / "bag")
    assert done.messages == 350
    assert done.lost_bytes > 512


def test_a_whole_bag_is_left_alone(tmp_path: Path) -> None:
    writer = _record(tmp_path / "bag", 1.0)
    writer.close()
    before = {path.name: path.read_bytes() for path in (tmp_path / "bag").iterdir()}
    assert repair(tmp_path / "bag").original is None
    assert {path.name: path.read_bytes() for path in (tmp_path / "bag").iterdir()} == before


def test_lost_metadata_is_made_again(tmp_path: Path) -> None:
    _record(tmp_path / "bag", 1.0).close()
    (tmp_path / "bag" / "metadata.yaml").unlink()
    repair(tmp_path / "bag")
    assert len(_messages(tmp_path / "bag")) == 200


def test_a_single_file_can_be_repaired(tmp_path: Path) -> None:
    file = tmp_path / "alone.mcap"
    file.write_bytes(_crashed(tmp_path / "bag", 1.0).read_bytes())
    assert repair(file).messages == 200
    assert not (tmp_path / "metadata.yaml").exists()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "not an MCAP file"),
        (b"time_s,power_w\n", "not an MCAP file"),
        (b"\x89MCAP0\r\n", "no whole message"),
    ],
)
def test_what_cannot_be_repaired_is_left_as_it_is(tmp_path: Path, content: bytes, said: str) -> None:
    file = tmp_path / "bag.mcap"
    file.write_bytes(content)
    with pytest.raises(LceError, match=said):
        repair(file)
    assert [path.name for path in tmp_path.iterdir()] == ["bag.mcap"]
    assert file.read_bytes() == content


def test_no_bag_and_an_empty_folder_are_named(tmp_path: Path) -> None:
    with pytest.raises(LceError, match="no such bag"):
        repair(tmp_path / "nothing")
    with pytest.raises(LceError, match=r"holds 0 \.mcap files"):
        repair(tmp_path)


def test_an_earlier_repair_is_not_overwritten(tmp_path: Path) -> None:
    other = _crashed(tmp_path / "bag", 1.0).with_name("recording.mcap.truncated")
    other.write_text("kept")
    with pytest.raises(LceError, match="was repaired before"):
        repair(tmp_path / "bag")
    assert other.read_text() == "kept"
