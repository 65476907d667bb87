# SPDX-License-Identifier: Apache-2.0
"""`lce prepare`: runs cut, detrended, resampled or merged by a recipe."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from lce_app.cli.arguments import add_runs, check_inputs, print_files

EXAMPLES = ("lce prepare runs/pulse.csv --recipe recipe.yaml --out prepared",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce prepare`."""
    add_runs(parser)
    parser.add_argument("--recipe", type=Path, required=True, metavar="R.yaml", help="the steps, as below")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the prepared runs")
    parser.add_argument("--force", action="store_true", help="overwrite runs that exist")
    parser.epilog = """\
It writes DIR/NAME.csv, and beside it NAME.yaml (conditions, where the run came from) and NAME.recipe.yaml. The
recordings stay as they are. A recipe is YAML; times in s, levels in degC or m, files named from the folder of the run:

  format: lce-recipe-1
  steps:
    - {step: merge, file: displacement.csv, at_s: 0.35}    # other channels, or a later recording
    - {step: cut, begin_s: 20, end_s: 24.5, channels: [temperature]}    # without channels: all sensors
    - {step: detrend, channel: displacement, order: line, rest: [[0, 5], [90, 100]]}
    - {step: detrend, channel: temperature, order: offset, rest: [[0, 5]], level: 22.5}
    - {step: resample, dt_s: 0.05}    # means; the laser power keeps its energy"""


def main(args: argparse.Namespace) -> int:
    """Prepare every run, and say what was done."""
    check_inputs(args.runs, [args.recipe])
    from lce_app.use_cases.prepare import prepare_runs

    found = prepare_runs(args.runs, args.recipe, args.out, args.force)
    for warning in dict.fromkeys(said for prepared in found for said in prepared.warnings):
        print(f"lce: warning: {warning}", file=sys.stderr)
    print_files(*(prepared.file for prepared in found))
    return 0
