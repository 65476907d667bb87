# SPDX-License-Identifier: Apache-2.0
"""Effect files that the page may run: an effect is a program, and opening a folder must not start one."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

from lce_data.errors import LceError

if TYPE_CHECKING:
    from lce_model.effects import Effect


class TrustedEffects:
    """Files whose content a job of this session wrote or the user trusted; they are known by its SHA-256."""

    def __init__(self) -> None:
        self._contents: set[str] = set()

    def trust(self, file: Path) -> None:
        """Allow a file to be run, as long as its content stays as it is."""
        self._contents.add(sha256(file))

    def __contains__(self, file: Path) -> bool:
        return file.is_file() and sha256(file) in self._contents

    def effect(self, file: Path) -> Effect:
        """The effect of a file. Raises LceError if the file is not trusted, or is wrong."""
        from lce_model.effects import find

        if file not in self:
            raise LceError(f"{file.name}: not run, because it was not written in this session and is not trusted")
        return find(str(file))


def sha256(file: Path) -> str:
    """Of the content of a file; "" if there is none."""
    return hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else ""
