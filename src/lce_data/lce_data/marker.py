# SPDX-License-Identifier: Apache-2.0
"""Markers: events of a run that somebody marked while it was recorded."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

LONGEST: Final = 200
"""Characters of a marker's text that are read; the page writes no more."""


@dataclass(frozen=True)
class Marker:
    """A moment [s] on the time of a run, and a short text about it."""

    time_s: float
    text: str


def one_line(text: str) -> str:
    """A marker's text: one line of at most `LONGEST` characters, whatever was typed or recorded."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())[:LONGEST]


def decode_markers(log_time_ns: Sequence[int], cdr: Sequence[bytes]) -> tuple[Marker, ...]:
    """The markers of rcl_interfaces/Log messages, by their stamps [s], or when they were recorded if those are zero.

    The text may be any bytes: what is no UTF-8 is replaced.
    """
    return tuple(sorted(map(_decode, log_time_ns, cdr), key=lambda marker: marker.time_s))


def _decode(log_time_ns: int, cdr: bytes) -> Marker:
    """Time and ``msg`` of one message: CDR header, sec, nanosec, level, padding, and two texts with their lengths."""
    order = "<" if cdr[1] & 1 else ">"
    sec, nanosec, name_length = struct.unpack_from(f"{order}iI4xI", cdr, 4)
    begin = 20 + name_length + -name_length % 4
    (length,) = struct.unpack_from(f"{order}I", cdr, begin)
    text = cdr[begin + 4 : begin + 4 + length].rstrip(b"\0").decode(errors="replace")
    stamp_ns = sec * 1_000_000_000 + nanosec
    return Marker((stamp_ns or log_time_ns) * 1e-9, one_line(text))
