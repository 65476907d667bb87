# SPDX-License-Identifier: Apache-2.0
"""`lce add`: add an effect to a model, refit it, and say whether that helped."""

from __future__ import annotations

import argparse
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
from lce_data.units import after_number

if TYPE_CHECKING:
    from lce_app.use_cases.add_effect import Added

EXAMPLES = ("lce add creep runs/pulse* --test runs/prbs --model m.yaml --out m2.yaml",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce add`."""
    parser.add_argument("effect", metavar="EFFECT", help="a name of the library (lce effects), or a file of yours")
    add_runs(parser)
    add_test_runs(parser)
    add_model(parser)
    add_bounds(parser)
    parser.add_argument("--out", type=Path, required=True, metavar="M2.yaml", help="model file to write")
    parser.add_argument(
        "--report", type=Path, metavar="F.html", help="write the errors and the series as one HTML file"
    )


def main(args: argparse.Namespace) -> int:
    """Add, refit, write the model file, print what it did."""
    check_inputs([*args.runs, *args.test], [args.model])
    check_outputs(args.out, args.report)
    from lce_app.cli.progress_bar import FitBar
    from lce_app.use_cases.add_effect import add_effect

    with FitBar() as bar:
        found = add_effect(
            args.effect,
            args.runs,
            args.model,
            args.out,
            args.test,
            bounds=bounds(args),
            report_file=args.report,
            progress=bar,
        )
    print(summary(found))
    print_files(args.out, args.report)
    return 0


def summary(found: Added) -> str:
    """The sentence, the errors of each run, the parameters of the effect, its strength by run, and the models tried."""
    from lce_app.cli.table import as_text

    addition, tables = found.addition, found.tables
    values = []
    for value in addition.model.values:
        if value.term == addition.effect:
            error = "" if value.standard_error is None else f" ± {value.standard_error:.2g}"
            values.append(f"{value.key} = {value.value:.4g}{error}{after_number(value.unit)}")
    parts = [as_text(tables.errors), "\n".join(values), as_text(tables.strengths), as_text(tables.history)]
    if addition.at_bounds:
        parts.append("\n".join(["At a bound:", *(f"- {bound.sentence}" for bound in addition.at_bounds)]))
    return "\n\n".join([addition.sentence, *parts])
