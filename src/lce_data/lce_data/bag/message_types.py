# SPDX-License-Identifier: Apache-2.0
"""Message definitions and type hashes, which a bag carries so that any tool can read it."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lce_data.errors import LceError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore


@dataclass(frozen=True)
class MessageType:
    """A message type: its name `pkg/msg/Name`, RIHS01 hash, and text with those of all it is made of."""

    name: str
    hash: str
    definition: str


@cache
def message_type(name: str) -> MessageType:
    """Look up `pkg/msg/Name` of ROS 2 Jazzy, or of the ROS prefix. Raises LceError if it is in neither."""
    store = _store()
    if name not in store.fielddefs:
        _register_installed(store, name)
    definition, _ = store.generate_msgdef(name, ros_version=2)
    return MessageType(name, store.hash_rihs01(name), definition)


@cache
def _store() -> Typestore:
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


def _register_installed(store: Typestore, name: str) -> None:
    """Register a type that Jazzy does not bring, and what it is made of, from the .msg files of the ROS prefix."""
    from rosbags.typesys import TypesysError, get_types_from_msg

    found: dict[str, Any] = {}
    waiting = [name]
    while waiting:
        missing = waiting.pop()
        if missing in found or missing in store.fielddefs:
            continue
        file = _message_file(missing)
        try:
            found |= get_types_from_msg(file.read_text(encoding="utf-8"), missing)
        except TypesysError as error:
            raise LceError(f"{file}: {error}") from None
        waiting += _parts(found[missing][1])
    store.register(found)


def _parts(fields: object) -> list[str]:
    """Names of the message types in rosbags' description of fields: nested tuples of names, kinds and lengths."""
    if isinstance(fields, str):
        return [fields] if "/msg/" in fields else []
    return [name for field in fields for name in _parts(field)] if isinstance(fields, list | tuple) else []


def _message_file(name: str) -> Path:
    package, _, message = name.split("/")
    for prefix in filter(None, [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]):
        path = Path(prefix) / "share" / package / "msg" / f"{message}.msg"
        if path.is_file():
            return path
    raise LceError(f"message type {name} is not installed (no {package}/msg/{message}.msg in the ROS prefix)")
