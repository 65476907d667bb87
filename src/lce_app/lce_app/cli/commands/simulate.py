# SPDX-License-Identifier: Apache-2.0
"""`lce simulate`: a model without ROS, a power waveform in, a CSV run out."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lce_data.waveforms import Floats


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce simulate`."""
    parser.add_argument("--model", type=Path, metavar="M.yaml", required=True, help="model file")
    parser.add_argument("--input", metavar="wave.csv", required=True, help="columns time_s,power_w; or a protocol")
    parser.add_argument("--out", type=Path, metavar="run.csv", required=True, help="where the run is written")
    parser.add_argument("--set", action="append", default=[], metavar="TERM.PARAM=V", help="set a parameter")
    parser.add_argument("--force", action="store_true", help="overwrite --out")
    parser.epilog = (
        "Rows at the times of the input, or at 100 Hz where its steps are longer; powers are held in between."
    )


def main(args: argparse.Namespace) -> int:
    """Simulate and write `time_s,power_w,temperature_c,displacement_m`, less the stages the model lacks."""
    import numpy as np

    from lce_app.cli.settings import parse_settings
    from lce_data.errors import LceError
    from lce_data.files import write_atomically
    from lce_data.units import KELVIN
    from lce_model import load_model, simulate

    if args.out.exists() and not args.force:
        raise LceError(f"{args.out}: exists already; --force overwrites it")
    model = load_model(args.model).configured(parse_settings(args.set))
    time_s, power_w = _input(args.input)
    run = simulate(model, time_s, power_w)
    columns = {"time_s": ("%.9g", time_s), "power_w": ("%.9g", power_w)}
    if model.thermal != "none":
        columns["temperature_c"] = "%.6f", run.measured_temperature_k - KELVIN
    if model.deformation != "none":
        columns["displacement_m"] = "%.9e", run.measured_displacement_m
    for name, (_, values) in columns.items():
        if not np.isfinite(values).all():
            raise LceError(f"{args.model}: {name} is not finite under {args.input}")
    row = ",".join(form for form, _ in columns.values())
    lines = [row % values for values in zip(*(array.tolist() for _, array in columns.values()), strict=True)]
    write_atomically(args.out, "\n".join([",".join(columns), *lines, ""]))
    print(args.out)
    return 0


def _input(text: str) -> tuple[Floats, Floats]:
    """Time [s] and power [W] of a wave file or a protocol, in steps of 10 ms at most."""
    import numpy as np

    from lce_data.wave_file import read_wave
    from lce_experiment import protocols

    if Path(text).suffix.lower() == ".csv":
        time_s, power_w = read_wave(Path(text))
        if time_s.size > 1 and np.diff(time_s).max() <= 1.001 / protocols.RATE_HZ:
            return time_s, power_w
    wave = protocols.one(text)
    return wave.time_s, wave.power_w
