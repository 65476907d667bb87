# SPDX-License-Identifier: Apache-2.0
"""`lce design`: the experiment that tells two effects apart."""

from __future__ import annotations

import argparse
from pathlib import Path

from lce_app.cli.arguments import add_model, check_inputs
from lce_data.errors import LceError
from lce_data.units import KELVIN


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce design`."""
    add_model(parser)
    parser.add_argument("--between", required=True, metavar="A,B", help="two effects of the library, or files of yours")
    parser.add_argument("--max-power", type=float, default=2.0, metavar="W", help="limit of the laser power (2 W)")
    parser.add_argument(
        "--max-temperature", type=float, default=110.0, metavar="C", help="limit of the strip's temperature (110 °C)"
    )
    parser.add_argument("--duration", type=float, default=150.0, metavar="S", help="longest experiment (150 s)")
    parser.add_argument("--out", type=Path, required=True, metavar="wave.csv", help="waveform to write")
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of the waveforms tried; the same seed gives the same result"
    )


def main(args: argparse.Namespace) -> int:
    """Search, write the waveform, say what it is worth."""
    first, comma, second = args.between.partition(",")
    if not (comma and first and second):
        raise LceError(f"--between {args.between}: expected two effects, A,B")
    check_inputs(models=[args.model])
    from lce_analysis.options import DesignOptions
    from lce_app.cli.progress_bar import FitBar
    from lce_app.use_cases.design import Options, design

    limits = DesignOptions(args.max_power, args.max_temperature + KELVIN, args.duration, args.seed)
    with FitBar() as bar:
        designed = design(args.model, (first, second), args.out, Options(limits), bar)
    found = designed.design
    print(f"{found.protocol}, scaled to the limits: {found.time_s[-1]:.0f} s, {found.power_w.max():.2f} W at most,")
    print(f"{found.hottest_k - KELVIN:.0f} °C at most. After the rival is refitted, {found.separation:.1f} standard")
    advice = "" if designed.plain else " That is too little to tell them apart: give more time, power or temperature."
    print(f"deviations of the sensor noise remain between the two.{advice}")
    print(f"{args.out}   (lce run {args.out})")
    return 0
