# SPDX-License-Identifier: Apache-2.0
"""`lce diagnose`: which physical effect is missing?"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.use_cases import cluster

if TYPE_CHECKING:
    from lce_analysis.diagnosis import Diagnosis


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce diagnose`."""
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="a bag folder or a CSV")
    parser.add_argument("--test", nargs="+", type=Path, default=[], metavar="RUN", help="runs held out")
    parser.add_argument(
        "--model", type=Path, required=True, metavar="M.yaml", help="model file, as `lce fit` writes it"
    )
    parser.add_argument("--effect", action="append", default=[], metavar="FILE.py", help="a candidate of your own")
    parser.add_argument("--json", type=Path, metavar="F", help="write the numbers as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the evidence as one HTML file")
    cluster.add_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Diagnose, print the answer and the candidates, write what was asked for."""
    from lce_analysis.diagnosis import diagnose
    from lce_analysis.identification.homogeneity import outlier_runs
    from lce_app.cli.progress_bar import FitBar
    from lce_data.files import write_atomically
    from lce_data.read_runs import read_runs
    from lce_model import load_model
    from lce_model.effects import find, library
    from lce_report.diagnosis_page import page

    model, runs, test_runs = load_model(args.model), read_runs(args.runs), read_runs(args.test)
    effects = [*library().values(), *(find(e) for e in args.effect)]
    with FitBar() as bar, cluster.chosen(args.backend, args.scheduler):
        diagnosis = diagnose(model, runs, test_runs, effects, bar)
        doubts = outlier_runs(runs, bar)
    for doubt in doubts:
        print(f"lce: {doubt}", file=sys.stderr)
    report = page(diagnosis, runs, test_runs) if args.report else ""
    if args.json:
        write_atomically(args.json, json.dumps(diagnosis.as_json(), indent=1) + "\n")
    if args.report:
        write_atomically(args.report, report)
    print(summary(diagnosis))
    for path in (args.json, args.report):
        if path:
            print(path)
    return 0


def summary(diagnosis: Diagnosis) -> str:
    """The answer, the errors before and after, and the candidates as a table."""
    lines = [*diagnosis.sentences, "", f"{'NRMSE':20s} {'before':>8s} {'after':>8s}"]
    for name, sides in diagnosis.error.items():
        for key, before in sides["before"].items():
            if before is not None:
                quantity = key.removesuffix("_nrmse")
                lines.append(f"{name + ' ' + quantity:20s} {before:8.2%} {sides['after'][key]:8.2%}")
    lines += ["", f"{'effect':27s} {'evidence':>9s} {'p':>8s} {'visible':>8s} {'strength':>10s}        looks like"]
    for s in diagnosis.scores:
        unit = s.effect.parameter(s.effect.strength).unit
        unit = "" if unit == "1" else unit
        strength = f"{s.expected_strength:10.3g} {unit:6s}"
        lines.append(
            f"{s.effect.name:27s} {s.evidence:9.4g} {s.p_value:8.1e} {s.visibility:8.1%} {strength} "
            f"{', '.join(diagnosis.aliases[s.effect.name])}".rstrip()
        )
    return "\n".join(lines)
