# SPDX-License-Identifier: Apache-2.0
"""Files: written whole or not at all, and read only if they are files and not pipes or devices."""

import csv
import os
import stat
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from lce_data.errors import LceError


def check_regular(path: Path) -> None:
    """Raise LceError unless a path leads to a regular file: a pipe, a socket or a device may never come to its end."""
    try:
        mode = path.stat().st_mode
    except OSError as error:
        raise LceError(f"{path}: {error.strerror}") from None
    except ValueError:  # a null character, which a YAML file may hold
        raise LceError(f"{str(path)!r}: not the name of a file") from None
    if stat.S_ISDIR(mode):
        raise LceError(f"{path}: a folder, not a file")
    if not stat.S_ISREG(mode):
        raise LceError(f"{path}: a pipe, a socket or a device, not a file")


def read_at_most(path: Path, most_bytes: int) -> bytes:
    """Read a regular file. Raises LceError if it cannot be read, or is longer than ``most_bytes``."""
    check_regular(path)
    try:
        with path.open("rb") as file:
            content = file.read(most_bytes + 1)
    except OSError as error:
        raise LceError(f"{path}: cannot be read ({error.strerror})") from None
    if len(content) > most_bytes:
        raise LceError(f"{path}: longer than {most_bytes / 1e6:g} MB, too long for such a file")
    return content


def name_of(path: Path) -> str:
    """The name of the run that a path holds: of a file without its ending, of a folder, which may have a dot, whole."""
    return path.name if path.is_dir() else path.stem


def printable(text: str) -> str:
    r"""The text, with ``\udcff`` and the like spelt out: a name of a file may hold bytes that are no UTF-8."""
    return text.encode(errors="backslashreplace").decode()


def read_csv_rows(path: Path) -> list[list[str]]:
    """Read the cells of a CSV file, row by row. Raises LceError if it cannot be read or is not such a text."""
    check_regular(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            return list(csv.reader(file))
    except OSError as error:
        raise LceError(f"{path}: cannot be read ({error.strerror})") from None
    except (UnicodeDecodeError, csv.Error):
        raise LceError(f"{path}: not a CSV text file") from None


def write_atomically(path: Path, text: str | Iterable[str]) -> None:
    """Write a text, or its pieces, beside its place, then move it there: no reader and no crash meets half of it.

    Raises LceError if the folder cannot be written.
    """
    new: Path | None = None
    try:
        with tempfile.NamedTemporaryFile(
            "w", dir=path.parent, prefix=f".{path.name}.", delete=False, encoding="utf-8", errors="backslashreplace"
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
