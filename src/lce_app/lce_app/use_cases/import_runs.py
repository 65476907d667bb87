# SPDX-License-Identifier: Apache-2.0
"""Make runs of foreign recordings: understand them, let the user decide what was guessed, and write them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from lce_data.errors import LceError
from lce_data.files import name_of, write_atomically
from lce_data.importing.read import read_foreign
from lce_data.importing.recording import Pick, Recording


@dataclass(frozen=True)
class Options:
    """What the user says of the files.

    Parameters
    ----------
    columns : which column of a table holds what.
    topics : which topic of a bag holds what.
    conditions : what is one number or word for every run, ``ambient_c`` for instance.
    overwrite : replace runs that exist.
    """

    columns: tuple[Pick, ...] = ()
    topics: tuple[Pick, ...] = ()
    conditions: Mapping[str, Any] = field(default_factory=dict)
    overwrite: bool = False


DEFAULTS = Options()

Decide = Callable[[Recording], tuple[Pick, ...]]
"""Given what was understood of a file, with guesses in it, what the user decides of each guess."""


def understand(files: Sequence[Path], options: Options = DEFAULTS, decide: Decide | None = None) -> list[Recording]:
    """Understand foreign files; nothing is written.

    Parameters
    ----------
    files : text tables, bag folders or MCAP files.
    options : what is known of them beforehand.
    decide : asked for each file in which something is guessed; what it decides holds for the files after it too.
        Guesses are taken as they are if None.

    Returns
    -------
    list[Recording]
        In the order of the files.

    Raises
    ------
    LceError
        If a file cannot be understood; names the row, the column or the topic.
    """
    found = []
    for file in files:
        recording = read_foreign(file, options.columns, options.topics)
        if decide is not None and recording.guesses:
            options = _decided(options, recording, decide(recording))
            recording = read_foreign(file, options.columns, options.topics)
        found.append(recording)
    return found


def import_runs(
    recordings: Sequence[Recording], out: Path, options: Options = DEFAULTS, report_file: Path | None = None
) -> list[Path]:
    """Write runs, each as NAME.csv with its conditions beside it as NAME.yaml.

    Parameters
    ----------
    recordings : as `understand` returns them.
    out : folder of the runs; it is made if need be.
    report_file : the runs as figures, one HTML file; not written if None.

    Raises
    ------
    LceError
        If a run could not be used, or a file exists already or would be written twice. Nothing is written then.

    Examples
    --------
    >>> found = understand([Path("day1.csv")], Options((Pick.parse("power=Q1:%"),)))  # doctest: +SKIP
    >>> import_runs(found, Path("runs"))  # doctest: +SKIP
    """
    names = [name_of(recording.path) for recording in recordings]
    if twice := {name for name in names if names.count(name) > 1}:
        raise LceError(f"several files are called {min(twice)}; import them into folders of their own")
    if out.exists() and not out.is_dir():
        raise LceError(f"{out}: is a file; --out names a folder")
    for recording in recordings:
        recording.check(out, options.conditions, options.overwrite)
    written = [recording.write(out, options.conditions, options.overwrite) for recording in recordings]
    if report_file is not None:
        from lce_report.pages.recordings import render_recordings

        write_atomically(report_file, render_recordings(recordings))
    return written


def _decided(options: Options, recording: Recording, picks: Sequence[Pick]) -> Options:
    """The options with what was decided of one file."""
    quantities = {pick.quantity for pick in picks}

    def with_these(before: Sequence[Pick]) -> tuple[Pick, ...]:
        return (*(pick for pick in before if pick.quantity not in quantities), *picks)

    if recording.is_bag:
        return replace(options, topics=with_these(options.topics))
    return replace(options, columns=with_these(options.columns))
