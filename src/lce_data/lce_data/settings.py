# SPDX-License-Identifier: Apache-2.0
"""TERM.PARAM=VALUE: parameters of a model as a user types them and as the simulator node takes them."""

from collections.abc import Iterable, Mapping

from lce_data.errors import LceError


def parse_settings(texts: Iterable[str]) -> dict[str, float]:
    """Read ``["lumped.gain=40"]`` as ``{"lumped.gain": 40.0}``; blank texts are skipped.

    Raises LceError naming a text of another form. Names and ranges are the model's to check.
    """
    settings: dict[str, float] = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not text.strip():
            continue
        if not equals:
            raise LceError(f"set {text}: not of the form term.param=value")
        try:
            settings[key.strip()] = float(value)
        except ValueError:
            raise LceError(f"set {text}: {value!r} is not a number") from None
    return settings


def format_settings(settings: Mapping[str, float]) -> list[str]:
    """The texts that :func:`parse_settings` reads, to the last digit."""
    return [f"{key}={value!r}" for key, value in settings.items()]
