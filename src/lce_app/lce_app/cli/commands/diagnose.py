# SPDX-License-Identifier: Apache-2.0
"""`lce diagnose`: which physical effect is missing?"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.cli.arguments import (
    add_bounds,
    add_cluster,
    add_model,
    add_runs,
    add_test_runs,
    bounds,
    check_inputs,
    check_outputs,
    print_files,
)

if TYPE_CHECKING:
    from lce_analysis.diagnosis import Diagnosis

EXAMPLES = ("lce diagnose runs/pulse* --test runs/prbs --model m.yaml --report diagnose.html",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce diagnose`."""
    add_runs(parser)
    add_test_runs(parser)
    add_model(parser)
    add_bounds(parser)
    parser.add_argument("--effect", action="append", default=[], metavar="FILE.py", help="a candidate of your own")
    parser.add_argument("--json", type=Path, metavar="F", help="write the numbers as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the evidence as one HTML file")
    parser.add_argument(
        "--evidence",
        action="store_true",
        help="print the score test of every effect too: evidence, p-value, visibility, what looks like it (in the "
        "report and the JSON anyway)",
    )
    add_cluster(parser)


def main(args: argparse.Namespace) -> int:
    """Diagnose, print the answer and the candidates, write what was asked for."""
    check_inputs([*args.runs, *args.test], [args.model])
    check_outputs(args.json, args.report)
    from lce_app.cli.progress_bar import FitBar
    from lce_app.cluster import Cluster
    from lce_app.use_cases.diagnose import Options, diagnose

    options = Options(effects=tuple(args.effect), bounds=bounds(args), cluster=Cluster(args.backend, args.scheduler))
    with FitBar() as bar:
        found = diagnose(args.runs, args.model, args.test, options, args.json, args.report, bar)
    print(summary(found, args.evidence))
    print_files(args.json, args.report)
    return 0


def summary(diagnosis: Diagnosis, evidence: bool = False) -> str:
    """The answer, the errors of the three models, what was added, and the ranking of what was tried."""
    from lce_app.cli.table import as_text
    from lce_report.tables import MEANING, diagnosis_tables

    tables = diagnosis_tables(diagnosis)
    parts = ["\n".join(diagnosis.sentences), as_text(tables.errors)]
    if tables.steps:
        parts.append(as_text(tables.steps))
        parts += [as_text(tables.varies)] if tables.varies else []
        parts += [as_text(tables.strengths)] if tables.strengths else []
    if tables.ranking:
        parts.append(as_text(tables.ranking, without=(MEANING,)))
    if tables.not_tried:
        parts.append(tables.not_tried)
    if evidence:
        parts.append(as_text(tables.evidence))
    return "\n\n".join(parts)
