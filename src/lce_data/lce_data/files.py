# SPDX-License-Identifier: Apache-2.0
"""Text files: written whole or not at all, and read as rows of cells."""

import csv
import os
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from lce_data.errors import LceError


def read_csv_rows(path: Path) -> list[list[str]]:
    """Read the cells of a CSV file, row by row. Raises LceError if it cannot be read or is not such a text."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            return list(csv.reader(file))
    except OSError as error:
        raise LceError(f"{path}: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise LceError(f"{path}: not a CSV text file") from None


def write_atomically(path: Path, text: str | Iterable[str]) -> None:
    """Write a text, or its pieces, beside its place, then move it there: no reader and no crash meets half of it.

    Raises LceError if the folder cannot be written.
    """
    new: Path | None = None
    try:
        with tempfile.NamedTemporaryFile(
            "w", dir=path.parent, prefix=f".{path.name}.", delete=False, encoding="utf-8"
        ) as file:
            new = Path(file.name)
            file.writelines([text] if isinstance(text, str) else text)
            file.flush()
            os.fsync(file.fileno())
        new.chmod(0o644)
        new.replace(path)
    except OSError as error:
        if new is not None:
            with suppress(OSError):
                new.unlink(missing_ok=True)
        raise LceError(f"{path}: cannot be written ({error.strerror})") from None
