# SPDX-License-Identifier: Apache-2.0
"""Message definitions and type hashes of the ROS prefix, which a bag carries so that any tool can read it."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from lce_data.errors import LceError

_SEPARATOR = "=" * 80 + "\nMSG: "
_INTEGERS = {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
_PRIMITIVE = {"bool", "byte", "char", "float32", "float64", "string", "wstring"} | _INTEGERS


@dataclass(frozen=True)
class MessageType:
    """A message type: its name `pkg/msg/Name`, RIHS01 hash, and text with those of all it is made of."""

    name: str
    hash: str
    definition: str


def message_type(name: str) -> MessageType:
    """Look `pkg/msg/Name` up in the prefixes of AMENT_PREFIX_PATH. Raises LceError if it is not installed."""
    top = _text(name)
    parts = [top, *(f"{_SEPARATOR}{part.replace('/msg/', '/')}\n{_text(part)}" for part in _made_of(name))]
    hashes = json.loads(_file(name, ".json").read_text(encoding="utf-8"))["type_hashes"]
    digest = next(entry["hash_string"] for entry in hashes if entry["type_name"] == name)
    return MessageType(name, digest, "\n".join(parts))


def _made_of(name: str) -> list[str]:
    """Message types inside `name`, each once, in the order in which they are met."""
    found: dict[str, None] = {}
    waiting = [name]
    while waiting:
        for part in _fields(waiting.pop(0)):
            if part not in found:
                found[part] = None
                waiting.append(part)
    return list(found)


def _fields(name: str) -> Iterator[str]:
    package = name.split("/")[0]
    for line in _text(name).splitlines():
        words = line.split("#")[0].split()
        if len(words) < 2 or "=" in words[1]:
            continue
        base = words[0].split("[")[0].split("<")[0]
        if base in _PRIMITIVE:
            continue
        yield f"{base.split('/')[0]}/msg/{base.split('/')[-1]}" if "/" in base else f"{package}/msg/{base}"


def _text(name: str) -> str:
    return _file(name, ".msg").read_text(encoding="utf-8")


def _file(name: str, suffix: str) -> Path:
    package, _, message = name.split("/")
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    for prefix in filter(None, prefixes):
        path = Path(prefix) / "share" / package / "msg" / f"{message}{suffix}"
        if path.is_file():
            return path
    raise LceError(f"message type {name} is not installed (no {package}/msg/{message}{suffix} in the ROS prefix)")
