# SPDX-License-Identifier: Apache-2.0
"""`lce control TARGET_MM…`: positioning experiments on the node graph, recorded and judged."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lce_experiment.graph import Plan
    from lce_experiment.positioning.judge import Positioning

MODES = ("double", "single", "model")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce control`."""
    parser.add_argument(
        "targets", nargs="+", type=float, metavar="TARGET_MM", help="displacement, a run from rest each"
    )
    parser.add_argument("--mode", choices=MODES, default="double", help="which controllers: see docs/control.md")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="the recording, a new folder; of several targets the folder of them; default runs/TIME_control_MODE",
    )
    parser.add_argument(
        "--model", type=Path, metavar="M.yaml", help="what the controllers know, and the simulated strip; has a default"
    )
    parser.add_argument(
        "--strip", type=Path, metavar="S.yaml", help="the simulated strip, where it is another one than the model"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="EFFECT.PARAM=V",
        help="a parameter of the strip alone, repeatable: what the controllers do not know of it",
    )
    parser.add_argument("--gains", type=Path, metavar="G.yaml", help="as `lce tune` writes them; default: control.yaml")
    parser.add_argument("--hold", type=float, default=60.0, metavar="S", help="how long a target is held (60 s)")
    parser.add_argument("--seed", type=int, metavar="N", help="of the sensor noise, 0 or more; default: a new one")
    parser.add_argument("--json", type=Path, metavar="F", help="write the figures as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the pictures as one HTML file")
    pace = parser.add_mutually_exclusive_group()
    pace.add_argument("--realtime", action="store_true", help="every node a process, in real time (default)")
    pace.add_argument("--fast", action="store_true", help="the same nodes on simulated time")
    parser.epilog = "A target out of reach is refused, with the range, before anything is started."


def main(args: argparse.Namespace) -> int:
    """Record a run for each target, print the figures, write what was asked for."""
    from lce_app.cli.settings import parse_settings
    from lce_data.files import write_atomically
    from lce_experiment.graph import default_strip, laser_limit_w
    from lce_experiment.positioning.judge import judge
    from lce_experiment.recording import interruptible, record, simulated_strip
    from lce_report.positioning_page import HEAD, page, rows

    model_file = args.model or default_strip()
    strip = simulated_strip(args.strip or model_file, parse_settings(args.set))
    plans = _plans(args, model_file)
    interruptible()
    runs: list[Positioning] = []
    for plan, target_mm in zip(plans, args.targets, strict=True):
        record(plan)
        print(plan.folder, flush=True)
        runs.append(judge(plan.folder, 1e-3 * target_mm, strip, laser_limit_w()))
    table = [HEAD, *rows(runs)]
    widths = [max(len(row[i]) for row in table) for i in range(len(HEAD))]
    print("\n".join("  ".join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) for row in table))
    if args.json:
        content = {"mode": args.mode, "targets": [run.as_json() for run in runs]}
        write_atomically(args.json, json.dumps(content, allow_nan=False) + "\n")
    if args.report:
        strip_text = ", ".join([str(args.strip or model_file), *args.set])
        about = (f"Model: {model_file}. Strip: {strip_text}.", f"Seed: {plans[0].seed}.")
        write_atomically(args.report, page(args.mode, runs, about))
    for path in (args.json, args.report):
        if path:
            print(path)
    return 0


def _plans(args: argparse.Namespace, model_file: Path) -> list[Plan]:
    """Everything that can be wrong is found here, before anything is started or written."""
    from lce_app.cli.settings import parse_settings
    from lce_data.errors import LceError
    from lce_experiment import graph
    from lce_experiment.positioning.judge import check_reach
    from lce_experiment.positioning.plan import SimulatedBench, plan
    from lce_experiment.recording import folders, seeded
    from lce_model import load_model

    if not 1.0 <= args.hold <= 3600.0:
        raise LceError(f"--hold {args.hold:g}: must be within [1, 3600] s")
    if args.gains is not None and not args.gains.is_file():
        raise LceError(f"{args.gains}: no such file")
    for target_mm in args.targets:
        check_reach(load_model(model_file), 1e-3 * target_mm, graph.laser_limit_w())
    seed = seeded(args.seed)
    names = [f"{target_mm:g}mm_{k}" if args.targets.count(target_mm) > 1 else f"{target_mm:g}mm"
             for k, target_mm in enumerate(args.targets)]  # fmt: skip
    bench = SimulatedBench(model_file, parse_settings(args.set), args.gains, args.strip)
    places = folders(args.out, f"control_{args.mode}", names)
    return [
        plan(args.mode, 1e-3 * target_mm, bench, folder, seed + k, args.hold, args.fast)
        for k, (target_mm, folder) in enumerate(zip(args.targets, places, strict=True))
    ]
