# SPDX-License-Identifier: Apache-2.0
"""Message definitions and type hashes, which a bag carries so that any tool can read it."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lce_data.channels import STAMPED_NUMBER
from lce_data.errors import LceError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

OWN: Final = {STAMPED_NUMBER: "std_msgs/Header header\nfloat64 value"}
"""The messages of lce_interfaces, for bags that are read where no workspace is sourced."""


@dataclass(frozen=True)
class MessageType:
    """A message type: its name `pkg/msg/Name`, RIHS01 hash, and text with those of all it is made of."""

    name: str
    hash: str
    definition: str


@cache
def message_type(name: str) -> MessageType:
    """Look up `pkg/msg/Name` in the ROS prefix, or else among our own and those of ROS 2 Jazzy.

    Raises LceError if it is nowhere.
    """
    store = _store()
    _register(store, name)
    definition, _ = store.generate_msgdef(name, ros_version=2)
    return MessageType(name, store.hash_rihs01(name), definition)


@cache
def _store() -> Typestore:
    """The types that were asked for: all of Jazzy's would cost every recorder 0.1 s and 6 MB."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.EMPTY)


def _register(store: Typestore, name: str) -> None:
    """Register a type and what it is made of, unless the store has it."""
    found: dict[str, Any] = {}
    waiting = [name]
    while waiting:
        missing = waiting.pop()
        if missing in found or missing in store.fielddefs:
            continue
        found |= _fields(missing)
        waiting += _parts(found[missing][1])
    if found:
        store.register(found)


def _fields(name: str) -> dict[str, Any]:
    """rosbags' description of a type, from the .msg file of the ROS prefix, or else from `OWN` or its copy of Jazzy."""
    from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore

    file = _message_file(name)
    if file is None and name in OWN:
        return dict(get_types_from_msg(OWN[name], name))
    if file is None:
        jazzy = get_typestore(Stores.ROS2_JAZZY).fielddefs
        if name not in jazzy:
            package, _, message = name.split("/")
            raise LceError(f"message type {name} is not installed (no {package}/msg/{message}.msg in the ROS prefix)")
        return {name: jazzy[name]}
    try:
        return dict(get_types_from_msg(file.read_text(encoding="utf-8"), name))
    except TypesysError as error:
        raise LceError(f"{file}: {error}") from None


def _parts(fields: object) -> list[str]:
    """Names of the message types in rosbags' description of fields: nested tuples of names, kinds and lengths."""
    if isinstance(fields, str):
        return [fields] if "/msg/" in fields else []
    return [name for field in fields for name in _parts(field)] if isinstance(fields, list | tuple) else []


def _message_file(name: str) -> Path | None:
    """The .msg file of a type in the ROS prefix, None if it is not there."""
    package, _, message = name.split("/")
    for prefix in filter(None, [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]):
        path = Path(prefix) / "share" / package / "msg" / f"{message}.msg"
        if path.is_file():
            return path
    return None
