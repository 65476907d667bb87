# SPDX-License-Identifier: Apache-2.0
"""`lce design`: the experiment that tells two effects apart."""

from __future__ import annotations

import argparse
from pathlib import Path

from lce_analysis.options import DesignOptions
from lce_app.cli.arguments import add_model, check_inputs, check_outputs
from lce_data.errors import LceError
from lce_data.units import KELVIN

EXAMPLES = ("lce design --model m.yaml --between creep,residual_strain --max-power 1.5 --out wave.csv",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce design`."""
    limits = DesignOptions()
    power_w, temperature_c, duration_s = limits.max_power_w, limits.max_temperature_k - KELVIN, limits.duration_s
    add_model(parser)
    parser.add_argument("--between", required=True, metavar="A,B", help="two effects of the library, or files of yours")
    for flag, default, metavar, about in (
        ("--max-power", power_w, "W", f"limit of the laser power ({power_w:g} W)"),
        ("--max-temperature", temperature_c, "C", f"limit of the strip's temperature ({temperature_c:g} °C)"),
        ("--duration", duration_s, "S", f"longest experiment ({duration_s:g} s)"),
    ):
        parser.add_argument(flag, type=float, default=default, metavar=metavar, help=about)
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
    check_outputs(args.out, table=True)
    from lce_app.cli.progress_bar import FitBar
    from lce_app.use_cases.design import Options, design

    limits = DesignOptions(args.max_power, args.max_temperature + KELVIN, args.duration, args.seed)
    with FitBar("separation {:.3g} σ") as bar:
        designed = design(args.model, (first, second), args.out, Options(limits), bar)
    print("\n".join(designed.sentences))
    print(f"{args.out}   (lce run {args.out})")
    return 0
