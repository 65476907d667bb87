# SPDX-License-Identifier: Apache-2.0
"""`lce compare`: where does a model fail?"""

from __future__ import annotations

import argparse
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.cli.arguments import add_model, add_runs, check_inputs, check_outputs, print_files

if TYPE_CHECKING:
    from lce_analysis.comparison.compare import Comparison

EXAMPLES = ("lce compare runs/* --model m.yaml --report compare.html",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce compare`."""
    add_runs(parser)
    add_model(parser)
    parser.add_argument("--json", type=Path, metavar="F", help="write the numbers as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the figures as one HTML file")
    parser.add_argument(
        "--drive",
        choices=("model", "measured"),
        default="model",
        help="what drives T→d: the model's thermal state (default), or the measured temperature, smoothed",
    )
    parser.add_argument(
        "--predictive-check",
        type=int,
        nargs="?",
        const=200,
        default=0,
        metavar="N",
        help="simulate the runs N times (200) with the noise of the sensors and the uncertainty of the parameters, and "
        "say which samples lie outside of 90 %% of that",
    )


def main(args: argparse.Namespace) -> int:
    """Compare, print a table and where the error sits, write what was asked for."""
    check_inputs(args.runs, [args.model])
    check_outputs(args.json, args.report)
    from lce_analysis.options import CompareOptions
    from lce_app.cli.progress_bar import FitBar
    from lce_app.use_cases.compare import compare
    from lce_data.progress import silent

    # Without the simulations nothing takes long.
    with FitBar() if args.predictive_check else nullcontext(silent) as bar:
        found = compare(
            args.runs,
            args.model,
            CompareOptions(drive=args.drive),
            args.json,
            args.report,
            args.predictive_check,
            progress=bar,
        )
    for warning in found.warnings:
        print(f"lce: {warning}", file=sys.stderr)
    print(_table(found.comparison))
    print("\n".join(["", *found.comparison.sentences, *(found.check.sentences if found.check else ())]))
    print_files(args.json, args.report)
    return 0


def _table(comparison: Comparison) -> str:
    from lce_app.cli.table import table

    rows: list[tuple[str, ...]] = [("run", "", "RMS error", "noise", "× noise", "NRMSE")]
    for run in comparison.runs:
        for channel, compared in run.channels.items():
            m, scale, unit = compared.metrics, channel.difference.factor, channel.difference.symbol
            rows.append(
                (
                    run.run.name,
                    channel.symbol,
                    f"{m.rms * scale:.3g} {unit:2s}",
                    f"{m.noise * scale:.2g} {unit:2s}",
                    f"{m.over_noise:.2f}",
                    f"{m.nrmse:.2%}",
                )
            )
    return table(rows, left=1)
