# SPDX-License-Identifier: Apache-2.0
"""Arguments that several commands have, and the check that comes before everything slow."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lce_data.errors import LceError
from lce_data.given_conditions import parse_conditions
from lce_data.settings import parse_settings

RECORDINGS = (".csv", ".mcap", ".db3")
"""Ends of files that hold what was measured."""


def add_runs(parser: argparse.ArgumentParser) -> None:
    """The recordings."""
    parser.add_argument(
        "runs",
        nargs="+",
        type=Path,
        metavar="RUN",
        help="a bag folder, or a CSV file with the columns time_s, power_w, temperature_c, displacement_m "
        "(what was not measured is left out)",
    )


def add_test_runs(parser: argparse.ArgumentParser) -> None:
    """Recordings that nothing is fitted to."""
    parser.add_argument("--test", nargs="+", type=Path, default=[], metavar="RUN", help="runs held out")


def add_model(parser: argparse.ArgumentParser) -> None:
    """The model file, which must be given."""
    parser.add_argument(
        "--model", type=Path, required=True, metavar="M.yaml", help="model file, as `lce fit` writes it"
    )
    add_effect_files(parser)


def add_effect_files(parser: argparse.ArgumentParser) -> None:
    """`--effect-file`, repeatable, for commands that read a model file; :func:`allow_effect_files` acts on it."""
    parser.add_argument(
        "--effect-file",
        action="append",
        type=Path,
        default=[],
        metavar="FILE.py",
        help="an effect file that the model lists: it may run in this command (lce trust: in every one)",
    )


def allow_effect_files(args: argparse.Namespace) -> None:
    """Trust what `--effect-file` names, for this command. Raises LceError if such a file cannot be read."""
    if files := getattr(args, "effect_file", ()):
        from lce_model import trust

        for file in files:
            trust.allow(file)


def add_settings(parser: argparse.ArgumentParser, metavar: str, about: str) -> None:
    """`--set`, repeatable; :func:`settings` reads it."""
    parser.add_argument("--set", action="append", default=[], metavar=metavar, help=about)


def settings(args: argparse.Namespace) -> dict[str, float]:
    """What `--set` gave, by TERM.PARAM. Raises LceError for a text of another form."""
    try:
        return parse_settings(args.set)
    except LceError as error:
        raise LceError(f"--{error}") from None


def add_bounds(parser: argparse.ArgumentParser) -> None:
    """`--bounds`, and `--hold` as it was called; :func:`bounds` reads it."""
    parser.add_argument(
        "--bounds",
        "--hold",
        action="append",
        default=[],
        metavar="TERM.PARAM=LO,HI",
        help="search this parameter between LO and HI, narrower or wider than by default; for more of them, again",
    )


def bounds(args: argparse.Namespace) -> dict[str, tuple[float, float]]:
    """What `--bounds` gave, by TERM.PARAM. Raises LceError for a text of another form."""
    ranges = {}
    for text in args.bounds:
        key, _, ends = text.partition("=")
        low, _, high = ends.partition(",")
        try:
            ranges[key.strip()] = float(low), float(high)
        except ValueError:
            raise LceError(f"--bounds {text}: expected TERM.PARAM=LOWER,UPPER") from None
    return ranges


def add_pace(parser: argparse.ArgumentParser) -> None:
    """Real or simulated time."""
    pace = parser.add_mutually_exclusive_group()
    pace.add_argument("--realtime", action="store_true", help="each node a process, in real time (default)")
    pace.add_argument(
        "--fast", action="store_true", help="the same nodes on simulated time, as quickly as the machine can"
    )


def add_conditions(parser: argparse.ArgumentParser) -> None:
    """What is to be said of a run; :func:`conditions` reads it."""
    about = parser.add_argument_group("notes", "kept in experiment.yaml and in the metadata of the bag")
    about.add_argument("--specimen", metavar="NAME", help="which strip")
    about.add_argument("--day", metavar="DAY", help="such as 2026-11-22")
    about.add_argument("--notes", metavar="TEXT", help="anything worth knowing later")
    about.add_argument(
        "--condition",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="strip_length_m (m), ambient_c (°C), load_n (N) or a key of your own; repeatable",
    )


def conditions(args: argparse.Namespace) -> dict[str, Any]:
    """What was said of a run, by key. Raises LceError for a text of another form or a value that cannot be."""
    words = condition_words(args.condition)
    named = {key: getattr(args, key) for key in ("specimen", "day", "notes")}
    return parse_conditions(words | {key: text for key, text in named.items() if text is not None})


def condition_words(texts: Iterable[str]) -> dict[str, str]:
    """``["ambient_c=22.5"]`` as words by key. Raises LceError for a text of another form."""
    words = {}
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals:
            raise LceError(f"--condition {text}: expected KEY=VALUE")
        words[key.strip()] = value.strip()
    return words


def add_cluster(parser: argparse.ArgumentParser) -> None:
    """More than one machine, for commands that fit many times."""
    parser.add_argument(
        "--backend",
        choices=("threads", "dask"),
        default="threads",
        help="where to fit: on the cores of this machine (default), or on a Dask cluster",
    )
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of the Dask cluster, as tcp://192.168.1.5:8786")


def check_inputs(runs: Iterable[Path] = (), models: Iterable[Path | None] = ()) -> None:
    """Raise LceError for the first run or model file that does not exist.

    A command calls it before it imports the physics, which takes seconds: a mistyped path is reported at once.
    """
    for run in runs:
        if not _exists(run):
            raise LceError(f"{run}: no such file or folder, or not yours to read")
    for model in models:
        if model is not None and not _exists(model):
            raise LceError(f"{model}: No such file or directory")


def check_outputs(*files: Path | None, table: bool = False) -> None:
    """Raise LceError for the first file that could not be written, before the minutes of work that it is to hold.

    Unless it is to be a table, it may not take the place of a recording, as by ``--out runs/*.csv``, of which the shell
    makes the first of them. Nor may any take that of what is known of a recording.
    """
    for file in files:
        if file is None:
            continue
        if not table and file.suffix.lower() in RECORDINGS and _exists(file):
            raise LceError(f"{file}: is a recording, which would be overwritten; name another file")
        if file.suffix == ".yaml" and _exists(file) and _describes_a_recording(file):
            raise LceError(f"{file}: says what is known of a recording, which would be lost; name another file")
        if _exists(file) and file.is_dir():
            raise LceError(f"{file}: is a folder; name a file in it")
        if not (_exists(file.parent) and file.parent.is_dir()):
            raise LceError(f"{file}: there is no folder {file.parent}; make it first")
        if not os.access(file.parent, os.W_OK):
            raise LceError(f"{file}: the folder {file.parent} cannot be written")


def _describes_a_recording(file: Path) -> bool:
    from lce_data.experiment_file import holds_experiment

    return holds_experiment(file)


def _exists(path: Path) -> bool:
    """Is there such a file or folder? A name that is too long, or a folder that is closed, holds none."""
    try:
        return path.exists()
    except OSError:
        return False


def print_files(*files: Path | None) -> None:
    """Print the paths of the files that were written, one a line."""
    for file in files:
        if file:
            print(file)
