# SPDX-License-Identifier: Apache-2.0
"""`lce tune`: controller gains on the identified model, then on the bench."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from lce_app.cli.arguments import add_effect_files, check_inputs, check_outputs, print_files
from lce_app.cli.table import table

EXAMPLES = ("lce tune --model m.yaml --out gains.yaml --overshoot 0.01",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce tune`."""
    parser.add_argument(
        "--model", type=Path, metavar="M.yaml", help="as `lce fit` writes it; default: that of `lce control`"
    )
    add_effect_files(parser)
    parser.add_argument("--out", type=Path, required=True, metavar="gains.yaml", help="ROS parameter file to write")
    parser.add_argument("--rise", type=float, default=math.inf, metavar="S", help="slowest rise to 80 %%; default: any")
    parser.add_argument("--overshoot", type=float, default=0.02, metavar="F", help="largest overshoot (0.02 of a step)")
    parser.add_argument(
        "--undershoot", type=float, default=0.02, metavar="F", help="largest fall below the target afterwards (0.02)"
    )
    parser.add_argument(
        "--settling", type=float, default=math.inf, metavar="S", help="slowest settling within 2 %%; default: any"
    )
    parser.add_argument(
        "--power-ripple",
        "--shake",
        type=float,
        default=0.05,
        metavar="W",
        help="largest RMS ripple of the power under noise (0.05 W); --shake is its former name",
    )
    parser.add_argument(
        "--bench",
        type=Path,
        nargs="?",
        const=Path(),
        metavar="STRIP.yaml",
        help="refine the gains on the running nodes, with this strip (default: the model itself) on simulated time",
    )
    parser.add_argument("--experiments", type=int, default=20, metavar="N", help="tries on the bench, each mode (20)")
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of the search; the same seed gives the same gains"
    )
    parser.add_argument("--report", type=Path, metavar="F.html", help="write steps, Bode diagrams and margins")
    parser.epilog = "The gains are those of both modes, double and single: `lce control --gains gains.yaml` takes them."


def main(args: argparse.Namespace) -> int:
    """Search, refine, write."""
    strip = None if args.bench == Path() else args.bench
    check_inputs(models=[args.model, strip])
    check_outputs(args.out, args.report)
    from lce_app.cli.progress_bar import FitBar
    from lce_app.use_cases.tune import Options, tune
    from lce_control.tuning.options import TuneOptions
    from lce_control.tuning.requirements import Requirements
    from lce_report.pages.tuning import HEAD, rows

    options = Options(
        model=args.model,
        requirements=Requirements(args.rise, args.settling, args.overshoot, args.undershoot, args.power_ripple),
        search=TuneOptions(seed=args.seed, experiments=args.experiments),
        on_nodes=args.bench is not None,
        strip=strip,
    )
    with FitBar("ITAE {:.3%}") as bar:
        found = tune(args.out, options, args.report, bar)
    print(table([HEAD, *rows(found.loops)]))
    print_files(args.out, args.report)
    return 0
