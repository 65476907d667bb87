# SPDX-License-Identifier: Apache-2.0
"""Markers of a recording: read with the times of the run, whatever their texts hold."""

import struct
from pathlib import Path

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from lce_data.bag.writer import BagWriter
from lce_data.errors import LceError
from lce_data.marker import LONGEST, Marker, decode_markers, one_line
from lce_data.read_runs import read_run
from lce_data.topics import LOG

STORE = get_typestore(Stores.ROS2_JAZZY)
BEGAN_NS = 1_700_000_000_000_000_000


def log(text: str, time_ns: int, name: str = "/lce/workbench") -> bytes:
    """A marker as ROS sends it."""
    sec, nanosec = divmod(time_ns, 1_000_000_000)
    stamp = STORE.types["builtin_interfaces/msg/Time"](sec, nanosec)
    message = STORE.types[LOG](stamp, 20, name, text, "", "", 0)
    return bytes(STORE.serialize_cdr(message, LOG))


def bag(folder: Path, markers: list[tuple[int, bytes]], namespace: str = "/lce") -> Path:
    """A run of ten samples in which there are markers, by the times [ns] at which they were recorded."""
    writer = BagWriter(folder)
    for topic in ("laser/power", "displacement"):
        writer.add_topic(f"{namespace}/{topic}", "std_msgs/msg/Float64", ())
        for k in range(10):
            at_ns = BEGAN_NS + k * 10_000_000
            writer.write(f"{namespace}/{topic}", at_ns, at_ns, struct.pack("<4sd", b"\0\1\0\0", k * 1e-4))
    if markers:
        writer.add_topic(f"{namespace}/marker", LOG, ())
    for time_ns, cdr in markers:
        writer.write(f"{namespace}/marker", time_ns, time_ns, cdr)
    writer.close()
    return folder


@pytest.mark.parametrize("namespace", ["/lce", "/left/arm"])
def test_markers_have_the_time_of_the_run(tmp_path: Path, namespace: str) -> None:
    late = log("lamp on", BEGAN_NS + 50_000_000)
    early = log("", BEGAN_NS + 20_000_000, name="odd")
    unstamped = log("by hand", 0)
    marked = [(BEGAN_NS + 90_000_000, late), (BEGAN_NS + 91_000_000, early), (BEGAN_NS + 80_000_000, unstamped)]
    run = read_run(bag(tmp_path / "bag", marked, namespace))
    assert [marker.text for marker in run.markers] == ["", "lamp on", "by hand"]
    np.testing.assert_allclose([marker.time_s for marker in run.markers], [0.02, 0.05, 0.08], atol=1e-6)
    assert read_run(tmp_path / "bag" / "recording.mcap").markers == run.markers


def test_a_run_without_markers_has_none(tmp_path: Path) -> None:
    assert read_run(bag(tmp_path / "bag", [])).markers == ()


def test_a_text_is_one_line_of_a_limited_length_and_may_be_any_bytes() -> None:
    assert one_line(" a\n\tb\x00\x1b[31m\u202ec \U0001f600 ") == "a b [31m c \U0001f600"
    assert len(one_line("x" * 1000)) == LONGEST
    odd = log("xyz", 1_000_000_000).replace(b"xyz", b"\xff<\xe4")
    assert decode_markers([5], [odd]) == (Marker(1.0, "\ufffd<\ufffd"),)


def test_a_bag_whose_markers_are_cut_short_is_told_to_be_unreadable(tmp_path: Path) -> None:

    with pytest.raises(LceError, match="not a readable bag"):
        read_run(bag(tmp_path / "bag", [(BEGAN_NS, log("x", BEGAN_NS)[:14])]))
