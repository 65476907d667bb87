# SPDX-License-Identifier: Apache-2.0
"""A session as one file: the runs in use, models, reports and versions, so that another machine can open it.

Effect files come along as text: the other machine trusts none of them.
"""

from __future__ import annotations

import platform
import zlib
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile

from lce_app.workbench.session import NAME, Session
from lce_data import __version__
from lce_data.errors import LceError
from lce_data.experiment_file import FILE_NAME

VERSIONS: Final = "versions.txt"
MOST_BYTES: Final = 20_000_000_000
"""Content of an archive that is unpacked, at most: a day of recordings is some hundred megabytes."""


DAMAGED: Final = (BadZipFile, OSError, EOFError, RuntimeError, zlib.error)
"""What zipfile raises for a file that is no archive, is cut short, has a password or a foreign compression."""


def write(session: Session, runs: list[Path], file: Path) -> None:
    """Write the archive of a session.

    Parameters
    ----------
    runs : the recordings to take along, in the folder of the session.

    Raises
    ------
    LceError
        If a file cannot be read, or the archive cannot be written.
    """
    root = session.folder.resolve()
    try:
        with ZipFile(file, "w", ZIP_DEFLATED, strict_timestamps=False) as archive:
            archive.writestr(f"{NAME}/{VERSIONS}", f"lce {__version__}\npython {platform.python_version()}\n")
            for path in _content(session, runs):
                if path.resolve().is_relative_to(root):  # a link in somebody's folder may lead to your own files
                    archive.write(path, path.relative_to(session.folder))
    except OSError as error:
        raise LceError(f"{file.name}: cannot be written ({error})") from None


def unpack(file: Path) -> Path:
    """Unpack an archive into a new folder of its name, beside it; the folder.

    Raises
    ------
    LceError
        If the file is no archive of a session, or the folder exists.
    """
    folder = file.with_suffix("")
    if folder.exists():
        raise LceError(f"{folder}: exists already; open it (lce workbench {folder}), or move it away")
    try:
        with TemporaryDirectory(prefix=f".{folder.name}-", dir=file.parent) as place, ZipFile(file) as archive:
            if f"{NAME}/{VERSIONS}" not in archive.namelist():
                raise LceError(f"{file}: no session of the workbench is in it")
            if sum(info.file_size for info in archive.infolist()) > MOST_BYTES:
                raise LceError(f"{file}: unpacks to more than {MOST_BYTES / 1e9:g} GB")
            whole = Path(place) / folder.name
            archive.extractall(whole)  # names that lead out of the folder are bent to stay in it
            whole.rename(folder)
    except DAMAGED as error:
        raise LceError(f"{file}: cannot be unpacked ({error})") from None
    return folder


def _content(session: Session, runs: list[Path]) -> Iterator[Path]:
    """Files to take along: the runs, what stands beside them, and the page's own, but for what was uploaded."""
    for run in runs:
        yield from (path for path in sorted(run.rglob("*")) if path.is_file()) if run.is_dir() else (run,)
        folder = run if run.is_dir() else run.parent
        in_the_bag = () if run.is_dir() else (run.with_suffix(".yaml"), folder / FILE_NAME)
        yield from (p for p in (*in_the_bag, folder.parent / f"{folder.name}.{FILE_NAME}") if p.is_file())
    own = (path for path in sorted(session.place.rglob("*")) if path.is_file())
    yield from (path for path in own if not path.is_relative_to(session.uploads))
