# SPDX-License-Identifier: Apache-2.0
"""`lce diagnose`: which physical effect is missing?"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.cli.arguments import add_cluster, add_model, add_runs, add_test_runs, check_inputs, print_files

if TYPE_CHECKING:
    from lce_analysis.diagnosis import Diagnosis


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce diagnose`."""
    add_runs(parser)
    add_test_runs(parser)
    add_model(parser)
    parser.add_argument("--effect", action="append", default=[], metavar="FILE.py", help="a candidate of your own")
    parser.add_argument("--json", type=Path, metavar="F", help="write the numbers as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the evidence as one HTML file")
    add_cluster(parser)


def main(args: argparse.Namespace) -> int:
    """Diagnose, print the answer and the candidates, write what was asked for."""
    check_inputs([*args.runs, *args.test], [args.model])
    from lce_app.cli.progress_bar import FitBar
    from lce_app.cluster import Cluster
    from lce_app.use_cases.diagnose import Options, diagnose

    options = Options(effects=tuple(args.effect), cluster=Cluster(args.backend, args.scheduler))
    with FitBar() as bar:
        found = diagnose(args.runs, args.model, args.test, options, args.json, args.report, bar)
    for warning in found.warnings:
        print(f"lce: {warning}", file=sys.stderr)
    print(summary(found.diagnosis))
    print_files(args.json, args.report)
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
