# SPDX-License-Identifier: Apache-2.0
"""`lce tune`: controller gains on the identified model, then on the bench."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lce_app.cli.progress_bar import FitBar
    from lce_control.tuning.requirements import Requirements, Tuned
    from lce_control.tuning.tasks import ModelBench
    from lce_experiment.positioning.plan import SimulatedBench


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce tune`."""
    parser.add_argument(
        "--model", type=Path, metavar="M.yaml", help="as `lce fit` writes it; default: that of `lce control`"
    )
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
        "--shake", type=float, default=0.05, metavar="W", help="most that noise may shake the power, RMS (0.05 W)"
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
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of the search; the same seed, the same gains")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write steps, Bode diagrams and margins")
    parser.epilog = "The gains are those of both modes, double and single: `lce control --gains gains.yaml` takes them."


def main(args: argparse.Namespace) -> int:
    """Search, refine, write."""
    from lce_app.cli.progress_bar import FitBar
    from lce_control.tuning.requirements import Requirements
    from lce_control.tuning.tasks import ModelBench, tune
    from lce_data.errors import LceError
    from lce_data.files import write_atomically
    from lce_experiment.graph import default_strip, laser_limit_w
    from lce_experiment.positioning.plan import SimulatedBench
    from lce_model import load_model
    from lce_report.tuning_page import HEAD, page, rows

    wanted = Requirements(args.rise, args.settling, args.overshoot, args.undershoot, args.shake)
    model_file = args.model or default_strip()
    bench = ModelBench.of(load_model(model_file), laser_limit_w())
    with FitBar("ITAE {:.3%}") as bar:
        found = tune(bench, wanted, bar, args.seed)
        _write(args.out, found, model_file)
        if args.bench is not None:
            strip_file = None if args.bench == Path() else args.bench
            experiment = SimulatedBench(model_file, strip_file=strip_file)
            try:
                found = _refined(experiment, args.experiments, bench, found, wanted, bar)
            except LceError as e:
                raise LceError(f"{e}. The gains in {args.out} are those found on the model") from e
            _write(args.out, found, model_file)
    table = [HEAD, *rows(found)]
    widths = [max(len(row[i]) for row in table) for i in range(len(HEAD))]
    print("\n".join("  ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) for row in table))
    if args.report:
        write_atomically(args.report, page(found, wanted, bench, (f"Model: {model_file}.",)))
    for path in (args.out, args.report):
        if path:
            print(path)
    return 0


def _write(out: Path, found: Sequence[Tuned], model_file: Path) -> None:
    from lce_data.files import write_atomically
    from lce_experiment.positioning.tuning_experiment import as_yaml

    _, double, single = found
    told = f"# Written by lce tune for the strip of {model_file.name}.\n"
    write_atomically(out, told + as_yaml({**double.parameters, **single.parameters}))


def _refined(
    experiment: SimulatedBench, tries: int, bench: ModelBench, found: Sequence[Tuned], wanted: Requirements, bar: FitBar
) -> tuple[Tuned, Tuned, Tuned]:
    from lce_control.tuning.search import refine
    from lce_experiment.positioning.tuning_experiment import on_the_bench

    inner, double, single = found
    double, single = (
        refine(on_the_bench(task, experiment, bench.targets_m, bench.duration_s), start, wanted, bar, tries)
        for task, start in ((bench.double(), double), (bench.single(), single))
    )
    return inner, double, single
