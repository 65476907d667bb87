# SPDX-License-Identifier: Apache-2.0
"""`term.param=value`, as a user types it."""

from __future__ import annotations

from collections.abc import Iterable

from lce_data.errors import LceError


def parse_settings(texts: Iterable[str]) -> dict[str, float]:
    """`["lumped.gain=40"]` as `{"lumped.gain": 40.0}`. Raises LceError; ranges are the model's to check."""
    changes: dict[str, float] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or "." not in key:
            raise LceError(f"--set {text}: not of the form term.param=value")
        try:
            changes[key.strip()] = float(value)
        except ValueError:
            raise LceError(f"--set {text}: {value!r} is not a number") from None
    return changes
