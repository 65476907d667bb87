# SPDX-License-Identifier: Apache-2.0
"""`lce simulate`: a model without ROS, a power waveform in, a CSV run out."""

from __future__ import annotations

import argparse
from pathlib import Path

from lce_app.cli.arguments import add_model, add_settings, check_inputs, print_files, settings
from lce_data.errors import LceError

EXAMPLES = ("lce simulate --model m.yaml --input wave.csv --out run.csv --set lumped.tau=25",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce simulate`."""
    add_model(parser)
    parser.add_argument("--input", metavar="wave.csv", required=True, help="columns time_s,power_w; or a protocol")
    parser.add_argument("--out", type=Path, metavar="run.csv", required=True, help="where the run is written")
    add_settings(parser, "TERM.PARAM=V", "set a parameter, repeatable")
    parser.add_argument("--force", action="store_true", help="overwrite --out")
    parser.epilog = (
        "Rows at the times of the input, or at 100 Hz where its steps are longer; powers are held in between."
    )


def main(args: argparse.Namespace) -> int:
    """Simulate and write `time_s,power_w,temperature_c,displacement_m`, less the stages the model lacks."""
    if args.out.exists() and not args.force:
        raise LceError(f"{args.out}: exists already; --force overwrites it")
    check_inputs(models=[args.model])
    from lce_app.use_cases.simulate import Options, simulate

    simulate(args.model, args.input, args.out, Options(settings(args), args.force))
    print_files(args.out)
    return 0
