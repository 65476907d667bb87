# SPDX-License-Identifier: Apache-2.0
"""`lce discover`: what does no effect of the library hold?"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.cli.arguments import (
    add_bounds,
    add_model,
    add_runs,
    add_test_runs,
    bounds,
    check_inputs,
    check_outputs,
    print_files,
)

if TYPE_CHECKING:
    from lce_app.use_cases.discover import Written

EXAMPLES = ("lce discover runs/pulse* --test runs/prbs --model m.yaml --out found.py --report found.html",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce discover`."""
    add_runs(parser)
    add_test_runs(parser)
    add_model(parser)
    add_bounds(parser)
    parser.add_argument("--out", type=Path, required=True, metavar="FOUND.py", help="the effect file to write")
    parser.add_argument("--json", type=Path, metavar="F", help="write the numbers as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the evidence as one HTML file")


def main(args: argparse.Namespace) -> int:
    """Discover, print the answer, write what was asked for."""
    check_inputs([*args.runs, *args.test], [args.model])
    check_outputs(args.out, args.json, args.report)
    from lce_app.cli.progress_bar import FitBar
    from lce_app.use_cases.discover import Options, discover

    with FitBar() as bar:
        written = discover(
            args.runs, args.model, args.out, args.test, Options(bounds=bounds(args)), args.json, args.report, bar
        )
    print(summary(written))
    print_files(args.json, args.report, *written.effects, *written.rivals.values())
    return 0


def summary(written: Written) -> str:
    """The answer, the errors of the three models, and what was tried."""
    from lce_app.cli.table import as_text
    from lce_report.discovery_tables import discovery_tables

    tables = discovery_tables(written.discovery)
    parts = ["\n".join(written.discovery.sentences), as_text(tables.errors)]
    parts += [as_text(table) for table in (tables.formulas, tables.tried) if table]
    parts += ["\n".join(_next(written))] if written.effects else []
    return "\n\n".join(parts)


def _next(written: Written) -> Iterator[str]:
    """What to type next."""
    for path in written.effects:
        yield f"lce add {path} RUN… --model M.yaml --out M2.yaml: adds it to a model"
    for path, rival in written.rivals.items():
        yield f"lce design --model M.yaml --between {path},{rival} --out wave.csv: the run that tells these apart"
