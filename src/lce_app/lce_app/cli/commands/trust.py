# SPDX-License-Identifier: Apache-2.0
"""`lce trust FILE`: let effect files run that a model lists."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLES = ("lce trust my_effect.py",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce trust`."""
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.py", help="an effect file; none: list the trusted")
    parser.epilog = (
        "An effect is a program that runs with all your rights: read it before you trust it. The file is known by the\n"
        "SHA-256 of its content, so that a changed one is no longer trusted."
    )


def main(args: argparse.Namespace) -> int:
    """Trust each file, without running it; or print what is trusted."""
    from lce_model import trust

    for file in args.files:
        print(f"{file}: trusted as {trust.trust(file)}")
    if not args.files:
        for digest, path in trust.trusted().items():
            print(f"{digest}  {path}")
    print(f"kept in {trust.trust_file()}; delete a line there to withdraw it")
    return 0
