# SPDX-License-Identifier: Apache-2.0
"""`lce control TARGET_MM…`: positioning experiments on the node graph, recorded and judged."""

from __future__ import annotations

import argparse
from pathlib import Path

from lce_app.cli.arguments import (
    add_conditions,
    add_effect_files,
    add_pace,
    add_settings,
    check_inputs,
    check_outputs,
    conditions,
    print_files,
    settings,
)
from lce_app.cli.table import table
from lce_data.errors import LceError
from lce_experiment.registry import CONTROLLERS

EXAMPLES = ("lce control 1.5 2.5 --fast --hold 30 --report control.html",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce control`."""
    parser.add_argument(
        "targets", nargs="+", type=float, metavar="TARGET_MM", help="displacement in mm, one run from rest each"
    )
    parser.add_argument("--mode", choices=tuple(CONTROLLERS), default="double", help="which controllers to run")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="new folder of the recording; of several targets, the folder that holds them; "
        "default runs/TIME_control_MODE",
    )
    parser.add_argument(
        "--model", type=Path, metavar="M.yaml", help="what the controllers know, and the simulated strip; has a default"
    )
    parser.add_argument(
        "--strip", type=Path, metavar="S.yaml", help="the simulated strip, if it is another one than the model"
    )
    add_effect_files(parser)
    add_settings(
        parser, "EFFECT.PARAM=V", "a parameter of the strip alone, repeatable: what the controllers do not know of it"
    )
    parser.add_argument("--gains", type=Path, metavar="G.yaml", help="as `lce tune` writes them; default: control.yaml")
    parser.add_argument("--hold", type=float, default=60.0, metavar="S", help="how long a target is held (60 s)")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of the sensor noise, 0 or more; default: a new one")
    parser.add_argument("--json", type=Path, metavar="F", help="write the figures as JSON")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write the curves as one HTML file")
    add_conditions(parser)
    add_pace(parser)
    parser.epilog = "A target out of reach is refused, with the range, before anything is started."


def main(args: argparse.Namespace) -> int:
    """Record a run for each target, print the figures, write what was asked for."""
    check_inputs(models=[args.model, args.strip])
    check_outputs(args.json, args.report)
    if args.gains is not None and not args.gains.is_file():
        raise LceError(f"{args.gains}: no such file")
    from lce_app.cli.progress_bar import RecordingBar
    from lce_app.use_cases.control import Options, control
    from lce_experiment import recording
    from lce_report.pages.positioning import HEAD, rows

    options = Options(
        mode=args.mode,
        model=args.model,
        strip=args.strip,
        settings=settings(args),
        gains=args.gains,
        hold_s=args.hold,
        seed=args.seed,
        fast=args.fast,
        conditions=conditions(args),
    )
    recording.interruptible()
    with RecordingBar() as bar:
        found = control(args.targets, args.out, options, args.json, args.report, bar, finished=bar.finished)
    print(table([HEAD, *rows(found.runs)]))
    print_files(args.json, args.report)
    return 0
