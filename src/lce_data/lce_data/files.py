# SPDX-License-Identifier: Apache-2.0
"""Files that are written whole or not at all."""

import os
import tempfile
from contextlib import suppress
from pathlib import Path

from lce_data.errors import LceError


def write_atomically(path: Path, text: str) -> None:
    """Write a text file beside its place and move it there, so that neither a reader nor a crash meets half of it.

    Raises LceError if the folder cannot be written.
    """
    new: Path | None = None
    try:
        with tempfile.NamedTemporaryFile(
            "w", dir=path.parent, prefix=f".{path.name}.", delete=False, encoding="utf-8"
        ) as file:
            new = Path(file.name)
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        new.chmod(0o644)
        new.replace(path)
    except OSError as error:
        if new is not None:
            with suppress(OSError):
                new.unlink(missing_ok=True)
        raise LceError(f"{path}: cannot be written ({error.strerror})") from None
