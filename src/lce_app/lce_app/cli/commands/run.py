# SPDX-License-Identifier: Apache-2.0
"""`lce run PROTOCOL`: an experiment on the node graph, recorded."""

from __future__ import annotations

import argparse
from pathlib import Path

from lce_app.cli.arguments import (
    add_conditions,
    add_effect_files,
    add_pace,
    add_settings,
    check_inputs,
    conditions,
    settings,
)

EXAMPLES = (
    "lce run pulse:amp=0.4,th=20 --fast",
    "lce run campaign --fast --out runs --model strip.yaml --set creep.share=0.1",
    "lce run pulse:amp=0.4,th=20 --specimen A7 --notes annealed --condition ambient_c=23.5",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce run`."""
    from lce_experiment import protocols

    parser.add_argument("protocol", metavar="PROTOCOL", help="what the laser does, see below")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="new folder of the recording; of a campaign, the folder that holds them; default runs/TIME_NAME",
    )
    parser.add_argument("--model", type=Path, metavar="M.yaml", help="the simulated strip; default: built in")
    add_effect_files(parser)
    add_settings(parser, "EFFECT.PARAM=V", "a parameter of the strip, repeatable; one of an effect adds the effect")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of the sensor noise, 0 or more; default: a new one")
    add_pace(parser)
    add_conditions(parser)
    parser.epilog = (
        f"{protocols.explain()}\n\n"
        "The path of each recording is printed on stdout. With --fast the same --seed gives the same\n"
        "data; the runs of a campaign take --seed, --seed + 1, ..."
    )


def main(args: argparse.Namespace) -> int:
    """Run the protocol, or each of a campaign, and print the paths of the recordings."""
    check_inputs(models=[args.model])
    from lce_app.cli.progress_bar import RecordingBar
    from lce_app.use_cases.record import Options, record
    from lce_experiment import recording

    options = Options(args.model, settings(args), args.seed, args.fast, conditions=conditions(args))
    recording.interruptible()
    with RecordingBar() as bar:
        record(args.protocol, args.out, options, bar, finished=bar.finished)
    return 0
