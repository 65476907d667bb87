# SPDX-License-Identifier: Apache-2.0
"""The numbers in a ROS message: where they are in a type, and how one is read."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any, Final

NUMBERS: Final = re.compile(r"float|double|boolean|octet|byte|u?int(8|16|32|64)")
FIXED_ARRAY: Final = re.compile(r"(?P<type>[^\[<]+)\[(?P<size>\d+)\]")
TYPE: Final = re.compile(r"(?P<package>[a-z][a-z0-9_]*)/(msg/)?(?P<name>[A-Za-z][A-Za-z0-9]*)")
LEFT_OUT: Final = ("builtin_interfaces/Time", "builtin_interfaces/Duration")
"""They say when a message is from, not what it says."""
DEEPEST: Final = 5
LONGEST: Final = 36
"""Elements of an array at most: a covariance in space has 36."""


@cache
def message_class(type_name: str) -> Any:
    """The class of a message type, ``pkg/msg/Name`` or ``pkg/Name``; None if it is not installed."""
    found = TYPE.fullmatch(type_name)
    if found is None:
        return None
    try:
        kind = getattr(importlib.import_module(f"{found['package']}.msg"), found["name"])
    except (ImportError, AttributeError):
        return None
    return kind if isinstance(kind, type) and hasattr(kind, "get_fields_and_field_types") else None


@cache
def numeric_paths(type_name: str) -> tuple[str, ...]:
    """Paths of the numbers in a type: ``temperature``, ``orientation.x``, ``covariance[0]``.

    Lists without a fixed length are left out.
    """
    return tuple(_paths(type_name, DEEPEST))


def getter(path: str) -> Callable[[Any], float]:
    """How the number at a path is read from a message."""
    steps = [int(word[1:-1]) if word.startswith("[") else word for word in re.findall(r"\[\d+\]|\w+", path)]

    def read(message: Any) -> float:
        value = message
        for step in steps:
            value = value[step] if isinstance(step, int) else getattr(value, step)
        return float(value[0] if isinstance(value, bytes) else value)

    return read


def _paths(type_name: str, depth: int) -> Iterator[str]:
    kind = message_class(type_name)
    if kind is None or depth == 0:
        return
    fields: dict[str, str] = kind.get_fields_and_field_types()
    for name, of_type in fields.items():
        array = FIXED_ARRAY.fullmatch(of_type)
        places = [f"{name}[{i}]" for i in range(min(int(array["size"]), LONGEST))] if array else [name]
        element = array["type"] if array else of_type
        if NUMBERS.fullmatch(element):
            yield from places
        elif element not in LEFT_OUT:
            for place in places:
                yield from (f"{place}.{inner}" for inner in _paths(element, depth - 1))
