# SPDX-License-Identifier: Apache-2.0
"""`lce compare`: where does a model fail?"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lce_analysis.compare import Comparison


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
    from lce_analysis.compare import as_json, compare
    from lce_analysis.experiment import read_runs
    from lce_analysis.report import render_comparison
    from lce_model import load_model
    from lce_model.model_file import write_atomically

    comparison = compare(load_model(args.model), read_runs(args.runs), args.drive)
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
    head = (
        f"{'run':20s} {'':3s} {'RMS':>10s} {'printed RMSE':>13s} {'NRMSE':>7s} {'SMAPE':>7s} "
        f"{'noise':>10s} {'× noise':>8s}"
    )
    lines = [head]
    for run in comparison.runs:
        for stage in run.stages:
            m = stage.metrics
            scale, unit, symbol = (1.0, "K ", "T") if stage.quantity == "temperature" else (1e6, "µm", "d")
            lines.append(
                f"{run.run.name:20s} {symbol:3s} {m.rms * scale:7.3g} {unit} {m.rmse_printed * scale:10.3g} {unit} "
                f"{m.nrmse:7.2%} {m.smape:7.2%} {m.noise * scale:7.2g} {unit} {m.over_noise:8.2f}"
            )
    return "\n".join(lines)
