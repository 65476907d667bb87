# SPDX-License-Identifier: Apache-2.0
"""The `lce` command.

Exit status: 0 done, 1 data or model unusable (one line on stderr), 2 usage, 130 Ctrl-C.
"""

from __future__ import annotations

import argparse
import importlib
import io
import os
import sys
from collections.abc import Sequence
from textwrap import indent
from types import ModuleType

from lce_app.cli.arguments import allow_effect_files
from lce_app.errors import ContradictoryOptions, OptionError
from lce_data import __version__
from lce_data.errors import LceError, did_you_mean

COMMANDS = {
    "run": "run an experiment on the node graph and record it",
    "tune": "controller gains on the identified model",
    "control": "position control on the node graph: targets in, figures out",
    "import": "make runs of foreign tables and bags: columns and units understood, shown and checked",
    "prepare": "cut, detrend, resample or merge runs by a recipe; the recordings stay as they are",
    "repair": "make a recording that a crash cut short readable by every tool",
    "fit": "identify a model from recorded runs",
    "compare": "where a model fails on recorded runs",
    "diagnose": "which physical effect a model lacks",
    "add": "add an effect to a model, and compare the error before and after",
    "discover": "what no effect of the library holds: described, drawn, written as an effect",
    "design": "the experiment that would tell two effects apart",
    "effects": "the library of physical effects, with equations and units",
    "simulate": "run a model without ROS: a power waveform in, a CSV out",
    "trust": "let effect files run that a model lists, as long as they stay as they are",
    "policy": "who may publish, read and call what in a secured graph (SROS2)",
    "workbench": "the same as a local web page",
}
"""Command name (module lce_app.cli.commands.NAME) and its line in `lce --help`."""
MODULES = {"import": "import_"}
"""Modules that cannot be called as their commands."""
FLAGS = {"hold_s": "hold"}
"""Flags that are not called as the field that they set."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return the exit status."""
    try:
        argv = sys.argv[1:] if argv is None else argv
        if isinstance(sys.stdout, io.TextIOWrapper):  # names of files, and texts in them, may be no Unicode
            sys.stdout.reconfigure(errors="backslashreplace")
        # Before numpy is imported: a fit keeps all cores busy by threads of its own; OpenBLAS's would be in the way.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        args = _parser(argv).parse_args(argv)
        command = command_module(args.command)
        allow_effect_files(args)
        status = int(command.main(args))
        sys.stdout.flush()
        return status
    except KeyboardInterrupt as interrupt:
        _print_error(interrupt, "interrupted")
        return 130
    except BrokenPipeError:  # the reader of our output, `head` for one, has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except ValueError as error:
        if not isinstance(error, LceError):
            raise
        _print_error(error, " ".join(_as_typed(error).split()))
        return 2 if isinstance(error, ContradictoryOptions) else 1


def command_module(name: str) -> ModuleType:
    """The module of a command."""
    return importlib.import_module(f"lce_app.cli.commands.{MODULES.get(name, name)}")


def _as_typed(error: LceError) -> str:
    """The error, with the flag that was typed in place of the option that it sets."""
    if isinstance(error, OptionError):
        return f"--{FLAGS.get(error.option, error.option)} {error.problem}"
    return str(error)


def _print_error(error: BaseException, line: str) -> None:
    """One line on stderr, after the notes that the error carries."""
    for text in (*getattr(error, "__notes__", ()), line):
        print(f"lce: {text}", file=sys.stderr)


def _parser(argv: Sequence[str]) -> argparse.ArgumentParser:
    """The parser with the arguments of the one command in `argv`: the others are not even imported."""
    parser = argparse.ArgumentParser(
        prog="lce",
        description="A bench for light-driven liquid crystal elastomers: run, record, identify, compare.",
        epilog="exit status: 0 done, 1 the data or the model cannot be used, 2 wrong usage, 130 Ctrl-C",
    )
    parser.add_argument("-V", "--version", action="version", version=f"lce {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    chosen = next((word for word in argv if not word.startswith("-")), None)
    for name, about in COMMANDS.items():
        sub = commands.add_parser(
            name, help=about, description=about, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        if name == chosen:
            module = command_module(name)
            module.add_arguments(sub)
            examples = indent("\n".join(module.EXAMPLES), "  ")
            sub.epilog = "\n\n".join(filter(None, [sub.epilog, f"examples:\n{examples}"]))
    if chosen is not None and chosen not in COMMANDS:
        parser.error(f"unknown command {chosen!r}{did_you_mean(chosen, COMMANDS)}; lce --help lists them")
    return parser


if __name__ == "__main__":
    sys.exit(main())
