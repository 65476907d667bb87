# SPDX-License-Identifier: Apache-2.0
"""Check the content of a file against a type, and say in one line what is wrong with it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final, TypeVar

import msgspec

from lce_data.errors import LceError
from lce_data.files import read_at_most

MOST_BYTES: Final = 2_000_000
"""Length of a YAML file at most: one of a fit to a hundred runs has a tenth of that."""
Kind = TypeVar("Kind")

_WORDS: Final = {
    "array": "a list",
    "bool": "true or false",
    "float": "a number",
    "int": "a whole number",
    "object": "keys with values",
    "str": "text",
}
_EXPECTED: Final = re.compile(r"Expected `(?P<types>[^`]+)`(?P<limit>[^,]*)")
_QUOTED: Final = re.compile(r"field `(?P<key>[^`]+)`")
_STEP: Final = re.compile(r"\.(?P<key>\w+)|\[(?P<index>\d+)\]|(?P<any>\[\.\.\.\])")


def checked(
    where: Path | str,
    content: object,
    kind: type[Kind],
    decode: Callable[[type, Any], Any] | None = None,
) -> Kind:
    """Make plain values, as a YAML or JSON file holds them, an object of a type.

    Parameters
    ----------
    where : file that holds the content, for the message.
    kind : a ``msgspec.Struct`` or a dataclass.
    decode : makes a value of a type that msgspec does not know, such as an array.

    Raises
    ------
    LceError
        Names the file, the key and the value: ``experiment.yaml: conditions.load_n is 'heavy'; it must be a number``.

    Examples
    --------
    >>> class Strip(msgspec.Struct, frozen=True):
    ...     length_m: float
    >>> checked("strip.yaml", {"length_m": 0.01}, Strip)
    Strip(length_m=0.01)
    """
    try:
        return msgspec.convert(content, kind, dec_hook=decode)
    except msgspec.ValidationError as error:
        raise LceError(f"{where}: {_reason(str(error), content, kind)}") from None


def read_yaml(path: Path) -> Any:
    """Read a YAML file as plain values; dates stay text, ``1e-3`` is a number.

    Raises LceError if it cannot be read, or holds what `lce_data.yaml_text.load` does not read.
    """
    import yaml

    from lce_data.yaml_text import load

    try:
        return load(read_at_most(path, MOST_BYTES).decode())
    except UnicodeDecodeError:
        raise LceError(f"{path}: not a YAML file (not a text)") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        why = f"line {mark.line + 1}: {getattr(error, 'problem', '')}" if mark else " ".join(str(error).split())
        raise LceError(f"{path}: not a YAML file ({why})") from None


def _reason(message: str, content: object, kind: type) -> str:
    """What is wrong, in words, from a message such as "Expected `float`, got `str` - at `$.conditions.load_n`"."""
    said, _, path = message.partition(" - at ")
    if path.startswith("`key`"):
        said, path = "a key is not text", path.removeprefix("`key` in ")
    key, value = _follow(path.strip("`").removeprefix("$"), content, kind)
    if found := _QUOTED.search(said):
        state = "is missing" if "missing" in said else "is not a key that is known here"
        return f"{key}.{found['key']} {state}".removeprefix(".")
    subject = f"{key or 'the content'} is {_short(value)}"
    if found := _EXPECTED.match(said):
        words = [_WORDS.get(t, t) for t in found["types"].split(" | ") if t != "null"]
        return f"{subject}; it must be {' or '.join(words)}{found['limit']}"
    if said.startswith("Invalid enum value"):
        return f"{subject}, which is not a value that is known here"
    return f"{subject}: {said}"


def _follow(path: str, content: Any, kind: type) -> tuple[str, Any]:
    """The key that a path of msgspec leads to, and the value there. It says ``[...]`` for any key of a mapping."""
    keys: list[str | int] = []
    value = content
    for step in _STEP.finditer(path):
        if step["any"]:
            keys.append(next(k for k in value if _is_refused(_with_only(content, keys, k), kind)))
        else:
            keys.append(step["key"] or int(step["index"]))
        value = value[keys[-1]]
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys)
    return text.removeprefix("."), value


def _with_only(content: Any, keys: list[str | int], key: Any) -> Any:
    """The content, of whose mapping at ``keys`` one key is left."""
    if not keys:
        return {key: content[key]}
    inner = _with_only(content[keys[0]], keys[1:], key)
    if isinstance(content, Mapping):
        return {**content, keys[0]: inner}
    return [inner if i == keys[0] else entry for i, entry in enumerate(content)]


def _is_refused(content: object, kind: type) -> bool:
    try:
        msgspec.convert(content, kind)
    except msgspec.ValidationError:
        return True
    return False


def _short(value: object) -> str:
    """A value as a message shows it: what it is, if it is long."""
    if isinstance(value, Mapping):
        return "keys with values"
    if isinstance(value, list | tuple):
        return "a list"
    if value is None:
        return "empty"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
