# SPDX-License-Identifier: Apache-2.0
"""`lce add`: add an effect to a model, and watch the error fall."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce add`."""
    parser.add_argument("effect", metavar="EFFECT", help="a name of the library (lce effects), or a file of yours")
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="a bag folder or a CSV")
    parser.add_argument("--test", nargs="+", type=Path, default=[], metavar="RUN", help="runs held out")
    parser.add_argument(
        "--model", type=Path, required=True, metavar="M.yaml", help="model file, as `lce fit` writes it"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="M2.yaml", help="model file to write")
    parser.add_argument("--report", type=Path, metavar="F.html", help="write before and after as one HTML file")


def main(args: argparse.Namespace) -> int:
    """Add, refit, write the model file, print before and after."""
    from lce_analysis.comparison.compare import compare
    from lce_analysis.diagnosis import add
    from lce_app.cli.progress_bar import FitBar
    from lce_data.files import write_atomically
    from lce_data.read_runs import read_runs
    from lce_model import load_model, save_model
    from lce_report.diagnosis_page import addition_page

    runs, test_runs = read_runs(args.runs), read_runs(args.test)
    with FitBar() as bar:
        addition = add(load_model(args.model), args.effect, runs, test_runs, bar)
    save_model(addition.model, args.out)
    every = [*runs, *test_runs]
    before, after = compare(addition.before, every), compare(addition.model, every)
    if args.report:
        write_atomically(args.report, addition_page(addition, before, after, {r.name for r in test_runs}))
    print(addition.sentence)
    print(f"\n{'run':24s} {'':12s} {'before':>10s} {'after':>10s}   (RMS error in units of the noise)")
    for a, b in zip(before.runs, after.runs, strict=True):
        for x, y in zip(a.stages, b.stages, strict=True):
            note = " (held out)" if a.run in test_runs else ""
            print(f"{a.run.name:24s} {x.quantity:12s} {x.metrics.over_noise:10.2f} {y.metrics.over_noise:10.2f}{note}")
    for value in addition.model.values:
        if value.term == addition.effect:
            error = "" if value.standard_error is None else f" ± {value.standard_error:.2g}"
            print(f"\n{value.key} = {value.value:.4g}{error} {value.unit}", end="")
    print("\n\n" + history_table(addition.model.fit["history"]))
    for path in (args.out, args.report):
        if path:
            print(path)
    return 0


def history_table(history: list[Mapping[str, Any]]) -> str:
    """The models tried: effects, NRMSE of d on training and on held-out runs, verdict."""
    lines = [f"{'model':44s} {'train T':>8s} {'train d':>8s} {'test T':>8s} {'test d':>8s}"]
    for entry in history:
        name = " + ".join(x for x in (entry["thermal"], entry["deformation"], *entry["effects"]) if x != "none")
        cells = [
            "        " if (x := entry[side][f"{q}_nrmse"]) is None else f"{x:8.2%}"
            for side in ("train", "test")
            for q in ("temperature", "displacement")
        ]
        lines.append(f"{name:44s} {' '.join(cells)}  {entry['verdict']}")
    return "\n".join(lines)
