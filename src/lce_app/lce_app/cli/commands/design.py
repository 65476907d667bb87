# SPDX-License-Identifier: Apache-2.0
"""`lce design`: the experiment that would tell two effects apart."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce design`."""
    parser.add_argument(
        "--model", type=Path, required=True, metavar="M.yaml", help="model file, as `lce fit` writes it"
    )
    parser.add_argument("--between", required=True, metavar="A,B", help="two effects of the library, or files of yours")
    parser.add_argument("--max-power", type=float, default=2.0, metavar="W", help="limit of the laser power (2 W)")
    parser.add_argument(
        "--max-temperature", type=float, default=110.0, metavar="C", help="limit of the strip's temperature (110 °C)"
    )
    parser.add_argument("--duration", type=float, default=150.0, metavar="S", help="longest experiment (150 s)")
    parser.add_argument("--out", type=Path, required=True, metavar="wave.csv", help="waveform to write")
    parser.add_argument("--seed", type=int, default=0, help="of the waveforms tried; the same seed, the same result")


def main(args: argparse.Namespace) -> int:
    """Search, write the waveform, say what it is worth."""
    from lce_analysis.design.design import Limits, design
    from lce_app.cli.progress_bar import FitBar
    from lce_data.errors import LceError
    from lce_data.files import write_atomically
    from lce_data.units import KELVIN
    from lce_model import load_model

    first, comma, second = args.between.partition(",")
    if not (comma and first and second):
        raise LceError(f"--between {args.between}: expected two effects, A,B")
    limits = Limits(args.max_power, args.max_temperature + KELVIN, args.duration)
    with FitBar() as bar:
        found = design(load_model(args.model), (first, second), limits, bar, args.seed)
    rows = [f"{t:.2f},{p:.6g}" for t, p in zip(found.time_s, found.power_w, strict=True)]
    write_atomically(args.out, "\n".join(["time_s,power_w", *rows]) + "\n")
    print(f"{found.protocol}, scaled to the limits: {found.time_s[-1]:.0f} s, {found.power_w.max():.2f} W at most,")
    print(f"{found.hottest_k - KELVIN:.0f} °C at most. After the rival is refitted, {found.separation:.1f} standard")
    print(
        "deviations of the sensor noise remain between the two."
        + (
            ""
            if found.separation > 5.0
            else " That is too little to tell them apart: give more time, power or temperature."
        )
    )
    print(f"{args.out}   (lce run {args.out})")
    return 0
