# SPDX-License-Identifier: Apache-2.0
"""`lce add`: add an effect to a model, and compare the error before and after."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.cli.arguments import add_model, add_runs, add_test_runs, check_inputs, print_files

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from lce_app.use_cases.add_effect import Added


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce add`."""
    parser.add_argument("effect", metavar="EFFECT", help="a name of the library (lce effects), or a file of yours")
    add_runs(parser)
    add_test_runs(parser)
    add_model(parser)
    parser.add_argument("--out", type=Path, required=True, metavar="M2.yaml", help="model file to write")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write before and after as one HTML file")


def main(args: argparse.Namespace) -> int:
    """Add, refit, write the model file, print before and after."""
    check_inputs([*args.runs, *args.test], [args.model])
    from lce_app.cli.progress_bar import FitBar
    from lce_app.use_cases.add_effect import add_effect

    with FitBar() as bar:
        found = add_effect(
            args.effect, args.runs, args.model, args.out, args.test, report_file=args.report, progress=bar
        )
    print(found.addition.sentence)
    print("\n".join(["", *_before_and_after(found)]))
    for value in found.addition.model.values:
        if value.term == found.addition.effect:
            error = "" if value.standard_error is None else f" ± {value.standard_error:.2g}"
            print(f"\n{value.key} = {value.value:.4g}{error} {value.unit}", end="")
    print("\n\n" + history_table(found.addition.model.fit["history"]))
    print_files(args.out, args.report)
    return 0


def _before_and_after(found: Added) -> list[str]:
    lines = [f"{'run':24s} {'':12s} {'before':>10s} {'after':>10s}   (RMS error in units of the noise)"]
    for before, after in zip(found.before.runs, found.after.runs, strict=True):
        name = before.run.name
        note = " (held out)" if name in found.held_out else ""
        for channel in before.channels:
            old, new = (side.channels[channel].metrics.over_noise for side in (before, after))
            lines.append(f"{name:24s} {channel.name:12s} {old:10.2f} {new:10.2f}{note}")
    return lines


def history_table(history: Sequence[Mapping[str, Any]]) -> str:
    """The models tried: effects, NRMSE of each sensor on training and on held-out runs, verdict."""
    from lce_data.channels import SENSORS

    heads = [f"{side} {channel.symbol}" for side in ("train", "test") for channel in SENSORS]
    lines = [f"{'model':44s} {' '.join(f'{head:>8s}' for head in heads)}"]
    for entry in history:
        name = " + ".join(x for x in (entry["thermal"], entry["deformation"], *entry["effects"]) if x != "none")
        cells = [
            "        " if (x := entry[side].get(f"{channel.name}_nrmse")) is None else f"{x:8.2%}"
            for side in ("train", "test")
            for channel in SENSORS
        ]
        lines.append(f"{name:44s} {' '.join(cells)}  {entry['verdict']}")
    return "\n".join(lines)
