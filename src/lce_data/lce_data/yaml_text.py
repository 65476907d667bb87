# SPDX-License-Identifier: Apache-2.0
"""YAML as this project reads and writes it."""

from __future__ import annotations

import re

import yaml

_FLOAT, _TIMESTAMP = "tag:yaml.org,2002:float", "tag:yaml.org,2002:timestamp"


class Loader(yaml.SafeLoader):
    """Dates stay text, as they were typed; ``1e-3`` is a number, which YAML 1.1 takes for text."""


class _Plain(yaml.SafeDumper):
    def ignore_aliases(self, data: object) -> bool:
        return True


Loader.yaml_implicit_resolvers = {
    first: [(tag, form) for tag, form in resolvers if tag != _TIMESTAMP]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
Loader.add_implicit_resolver(_FLOAT, re.compile(r"[-+]?[0-9]+(?:\.[0-9]*)?[eE][-+]?[0-9]+$"), list("-+0123456789"))


def dump(value: object) -> str:
    """YAML text, keys in the order given, no anchors."""
    return yaml.dump(value, Dumper=_Plain, sort_keys=False, allow_unicode=True)
