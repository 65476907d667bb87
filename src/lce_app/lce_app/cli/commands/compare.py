# SPDX-License-Identifier: Apache-2.0
"""`lce compare`: where does a model fail?"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lce_analysis.comparison.compare import Comparison


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce compare`."""
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="a bag folder or a CSV")
    parser.add_argument("--model", type=Path, required=True, metavar="M.yaml", help="model file")
    parser.add_argument("--json", type=Path, metavar="F", help="write the numbers as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the pictures as one HTML file")
    parser.add_argument(
        "--drive",
        choices=("model", "measured"),
        default="model",
        help="what drives T→d: the model's thermal state (default), or the measured temperature, smoothed",
    )


def main(args: argparse.Namespace) -> int:
    """Compare, print a table and where the error sits, write what was asked for."""
    from lce_analysis.comparison.compare import as_json, compare
    from lce_analysis.prediction import excited
    from lce_data.files import write_atomically
    from lce_data.read_runs import read_runs
    from lce_model import load_model
    from lce_report import render_comparison

    runs = read_runs(args.runs)
    comparison = compare(load_model(args.model), runs, args.drive)
    for run in runs:
        if not excited(run):
            print(f"lce: {run.name}: the laser power never changes; it says little of the model", file=sys.stderr)
    report = render_comparison(comparison) if args.report else ""
    if args.json:
        write_atomically(args.json, json.dumps(as_json(comparison), allow_nan=False) + "\n")
    if args.report:
        write_atomically(args.report, report)
    print(_table(comparison))
    print("\n".join(["", *comparison.sentences]))
    for path in (args.json, args.report):
        if path:
            print(path)
    return 0


def _table(comparison: Comparison) -> str:
    rows: list[tuple[str, ...]] = [("run", "", "RMS", "printed RMSE", "NRMSE", "SMAPE", "noise", "× noise")]
    for run in comparison.runs:
        for stage in run.stages:
            m = stage.metrics
            scale, unit, symbol = (1.0, "K", "T") if stage.quantity == "temperature" else (1e6, "µm", "d")
            rows.append(
                (
                    run.run.name,
                    symbol,
                    *(f"{value * scale:.3g} {unit:2s}" for value in (m.rms, m.rmse_printed)),
                    *(f"{value:.2%}" for value in (m.nrmse, m.smape)),
                    f"{m.noise * scale:.2g} {unit:2s}",
                    f"{m.over_noise:.2f}",
                )
            )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for name, *cells in rows:
        padded = (f"{cell:>{width}s}" for cell, width in zip(cells, widths[1:], strict=True))
        lines.append("  ".join([f"{name:{widths[0]}s}", *padded]))
    return "\n".join(lines)
