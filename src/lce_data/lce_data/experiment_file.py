# SPDX-License-Identifier: Apache-2.0
"""`experiment.yaml` beside a bag: what was asked of which strip, with which software, and how it ended."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import yaml

from lce_data import __version__
from lce_data.bag.metadata import dump
from lce_data.errors import LceError
from lce_data.files import write_atomically

FILE_NAME = "experiment.yaml"


def describe(
    protocol: str,
    mode: str,
    plant: str,
    seed: int,
    model: Path | None,
    settings: Mapping[str, float],
    conditions: Mapping[str, Any],
) -> dict[str, Any]:
    """What is known before the run. `model` None stands for the bench's default strip."""
    return {
        "format": "lce-experiment-1",
        "protocol": protocol,
        "mode": mode,
        "plant": plant,
        "seed": seed,
        "model": {
            "file": None if model is None else str(model),
            "sha256": None if model is None else hashlib.sha256(model.read_bytes()).hexdigest(),
            "set": dict(settings),
        },
        "conditions": dict(conditions),
        "software": {"lce": __version__, "python": platform.python_version()},
    }


def write(folder: Path, content: Mapping[str, Any]) -> None:
    """Write experiment.yaml into a bag folder."""
    write_atomically(folder / FILE_NAME, dump(dict(content)))


def update(folder: Path, **entries: Any) -> None:
    """Add entries to the experiment.yaml of a bag folder. Raises LceError where it cannot be read."""
    path = folder / FILE_NAME
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise LceError(f"{path}: {error}") from None
    write(folder, {**(content or {}), **entries})


def now() -> str:
    """The present time, UTC, as in the file."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")
