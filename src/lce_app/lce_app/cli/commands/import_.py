# SPDX-License-Identifier: Apache-2.0
"""`lce import`: foreign tables and bags made runs."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.cli.arguments import check_inputs, check_outputs, condition_words, print_files
from lce_data.errors import LceError

if TYPE_CHECKING:
    from lce_data.importing.recording import Pick, Recording, Signal

EXAMPLES = ("lce import recordings/*.csv --out runs --column temperature=T1:degC --column displacement=d:um",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce import`."""
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="a text table, or a bag with --topic")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the runs; made if need be")
    parser.add_argument(
        "--column",
        action="append",
        default=[],
        metavar="QUANTITY=NAME[:UNIT]",
        help="which column holds what: temperature=T1:degC; a number counts columns from 1, a minus in front of the "
        "unit flips the sign, load= says that no column is the load; repeatable",
    )
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="QUANTITY=TOPIC[.FIELD][:UNIT]",
        help="which topic of a bag holds what: temperature=/cam/temp; repeatable",
    )
    parser.add_argument(
        "--condition",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="what is one number or word for every run: ambient_c, load_n, strip_length_m, specimen, day; repeatable",
    )
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the runs as figures, one HTML file")
    parser.add_argument("--yes", action="store_true", help="take what is guessed")
    parser.add_argument("--force", action="store_true", help="overwrite runs that exist")
    parser.epilog = (
        "It finds separator, decimal sign, header and units, prints what it understood and what looks wrong, and asks "
        "about\nwhat it guessed (marked with ?) before it writes DIR/NAME.csv, with the conditions in DIR/NAME.yaml."
    )


def main(args: argparse.Namespace) -> int:
    """Understand, show, ask about guesses, write."""
    check_inputs(args.files)
    check_outputs(args.report)
    from lce_app.use_cases.import_runs import Options, import_runs, understand
    from lce_data.given_conditions import parse_conditions
    from lce_data.importing.recording import Pick

    options = Options(
        tuple(_parsed("--column", text, Pick) for text in args.column),
        tuple(_parsed("--topic", text, Pick) for text in args.topic),
        parse_conditions(condition_words(args.condition)),
        args.force,
    )
    recordings = understand(args.files, options, None if args.yes else _ask)
    for recording in recordings:
        _show(recording)
    print_files(*import_runs(recordings, args.out, options, args.report), args.report)
    return 0


def _parsed(option: str, text: str, pick: type[Pick]) -> Pick:
    try:
        return pick.parse(text)
    except LceError as error:
        raise LceError(f"{option} {error}") from None


def _show(recording: Recording) -> None:
    """The table of what was understood on stdout, and what looks wrong on stderr."""
    from lce_app.cli.table import table
    from lce_data.importing.recording import HEAD

    print(f"{recording.path}\n{table([HEAD, *recording.rows], left=3)}")
    if recording.left_out:
        print(f"left out: {', '.join(recording.left_out)}")
    for remark in recording.remarks:
        print(remark)
    print()
    for warning in recording.warnings():
        print(f"lce: warning: {warning}", file=sys.stderr)


def _ask(recording: Recording) -> tuple[Pick, ...]:
    """Decide each guess on the terminal. Raises LceError if there is no terminal to ask on."""
    option = "--topic" if recording.is_bag else "--column"
    try:
        _show(recording)
    except LceError as error:  # another answer may put it right
        print(f"lce: warning: {error}", file=sys.stderr)
    if not sys.stdin.isatty():
        asked = ", ".join(f"{signal.source} ({' and '.join(signal.guessed)})" for signal in recording.guesses)
        decided = shlex.join(word for signal in recording.guesses for word in (option, str(signal.pick)))
        raise LceError(f"{recording.path}: guessed of {asked}; {decided} says the same, --yes takes every guess")
    print("Return takes a guess, a unit replaces that of the guess (-mm flips the sign), no leaves the column out.")
    return tuple(_decide(signal) for signal in recording.guesses)


def _decide(signal: Signal) -> Pick:
    """The user's answer about one guess."""
    from lce_data.importing.recording import Pick

    while True:
        try:
            answer = input(f"{signal.source} is the {signal.quantity} in {signal.pick.unit}? ").strip()
        except EOFError:
            raise LceError(f"{signal.source}: no answer; nothing was written") from None
        if answer.casefold() in ("", "y", "yes"):
            return signal.pick
        if answer.casefold() in ("n", "no"):
            return Pick(signal.quantity, "")
        try:
            return Pick.parse(f"{signal.quantity}={signal.source}:{answer}")
        except LceError as error:
            print(error)
