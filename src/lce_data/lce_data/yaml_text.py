# SPDX-License-Identifier: Apache-2.0
"""YAML as this project reads and writes it. What is read may come from anywhere, so it is plain values and no more."""

from __future__ import annotations

import re
from typing import Any, Final

import yaml

DEEPEST: Final = 50
"""How deep lists and mappings may lie in each other."""
LARGEST: Final = 2**63
"""Whole numbers are smaller than this."""
_INT, _FLOAT, _TIMESTAMP = "tag:yaml.org,2002:int", "tag:yaml.org,2002:float", "tag:yaml.org,2002:timestamp"


class Loader(yaml.CSafeLoader):
    """Dates stay text, as they were typed; ``1e-3`` is a number, which YAML 1.1 takes for text."""


class Dumper(yaml.SafeDumper):
    """Text that `Loader` would take for a number is quoted; no anchors."""

    def ignore_aliases(self, data: object) -> bool:
        """Write out what occurs twice."""
        return True


def load(text: str) -> Any:
    """The plain values of a text.

    Raises yaml.YAMLError if it is no YAML, and for what a plain value does not need and an attack does: aliases, which
    make a short text a giant one, tags, and nesting deeper than `DEEPEST`.
    """
    depth = 0
    for event in yaml.parse(text, Loader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if isinstance(event, yaml.AliasEvent):
            raise _refused("an alias (*) is not read here; write the value out", event)
        if (tag := getattr(event, "tag", None)) not in (None, "!"):
            raise _refused(f"a tag ({tag}) is not read here", event)
        if depth > DEEPEST:
            raise _refused(f"nested deeper than {DEEPEST}", event)
    return yaml.load(text, Loader)


def dump(value: object) -> str:
    """YAML text, keys in the order given, no anchors."""
    return yaml.dump(value, Dumper=Dumper, sort_keys=False, allow_unicode=True)


def _refused(why: str, at: yaml.Event | yaml.Node) -> yaml.YAMLError:
    line = at.start_mark.line + 1 if at.start_mark else 0
    return yaml.YAMLError(f"line {line}: {why}")


def _int(loader: Loader, node: yaml.ScalarNode) -> int:
    try:
        number = loader.construct_yaml_int(node)
    except ValueError:  # Python reads no more than some thousand digits
        number = LARGEST
    if abs(number) >= LARGEST:
        raise _refused("a number of too many digits", node)
    return number


Loader.yaml_implicit_resolvers = {
    first: [(tag, form) for tag, form in resolvers if tag != _TIMESTAMP]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
for _kind in (Loader, Dumper):
    _kind.add_implicit_resolver(_FLOAT, re.compile(r"[-+]?[0-9]+(?:\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789"))
Loader.add_constructor(_INT, _int)
