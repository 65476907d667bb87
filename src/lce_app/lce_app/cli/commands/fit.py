# SPDX-License-Identifier: Apache-2.0
"""`lce fit`: identify a model from recorded runs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.use_cases import cluster

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lce_analysis.identification import FitResult
    from lce_app.cli.progress_bar import FitBar
    from lce_data.run import Run
    from lce_model import Model


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce fit`."""
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="a bag folder or a CSV")
    parser.add_argument("--out", type=Path, required=True, metavar="M.yaml", help="model file to write")
    parser.add_argument(
        "--thermal", default="lumped", metavar="T", help="P→T model: lumped (default), hammerstein_wiener, none"
    )
    parser.add_argument(
        "--deformation",
        default="equilibrium",
        metavar="D",
        help="T→d model: equilibrium (default), dynamic, kinetic, prandtl_ishlinskii, bouc_wen, none",
    )
    parser.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="E",
        help="add an effect: a name (lce effects), or a file of yours",
    )
    parser.add_argument("--start", type=Path, metavar="M0.yaml", help="model file with the values to start from")
    parser.add_argument("--set", action="append", default=[], metavar="TERM.PARAM=V", help="start from this value")
    parser.add_argument("--fix", action="append", default=[], metavar="TERM.PARAM", help="do not fit this parameter")
    parser.add_argument(
        "--hold",
        action="append",
        default=[],
        metavar="TERM.PARAM=LO,HI",
        help="search this parameter in a range only",
    )
    parser.add_argument(
        "--drive",
        choices=("model", "measured"),
        default="model",
        help="what drives T→d: the fitted thermal state (default), or the measured temperature, smoothed",
    )
    parser.add_argument("--per-run", action="store_true", help="one parameter set for each run (M-RUN.yaml)")
    parser.add_argument("--profile", action="store_true", help="profile likelihood of every parameter (minutes)")
    parser.add_argument(
        "--bootstrap", type=int, default=0, metavar="N", help="fit N times more, to resampled residuals"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random starts; the same seed, the same result")
    cluster.add_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Fit, print what was found, write the model file or files."""
    from lce_analysis.identification import fit, fit_each
    from lce_analysis.identification.homogeneity import outlier_runs
    from lce_app.cli.progress_bar import FitBar
    from lce_data.read_runs import read_runs
    from lce_model import save_model

    runs = read_runs(args.runs)
    model = _model(args, runs)
    with FitBar() as bar, cluster.chosen(args.backend, args.scheduler):
        if args.per_run:
            results = fit_each(model, runs, args.drive, bar, args.seed)
            targets = [args.out.with_name(f"{args.out.stem}-{run.name}{args.out.suffix}") for run in runs]
        else:
            results = (fit(model, runs, args.drive, bar, args.seed),)
            targets = [args.out]
        asked = not args.per_run and not results[0].interrupted
        doubts = outlier_runs(runs, bar) if asked else ()
        intervals = [[] if r.interrupted else _intervals(r, args, bar) for r in results]
    for doubt in doubts:
        print(f"lce: {doubt}", file=sys.stderr)
    for result, target, lines in zip(results, targets, intervals, strict=False):
        save_model(result.model, target)
        print("\n".join([_summary(result), *lines, "", str(target)]))
    if any(r.interrupted for r in results):
        print("lce: interrupted; the model file holds the best values so far", file=sys.stderr)
        return 130
    return 0


def _model(args: argparse.Namespace, runs: Sequence[Run]) -> Model:
    """The model to fit: what was asked for, less the stages that the runs say nothing of."""
    from lce_app.cli.settings import parse_settings
    from lce_data.errors import LceError
    from lce_model import default_model, load_model

    thermal, deformation = args.thermal, args.deformation
    if thermal != "none" and all(run.power is None for run in runs):
        thermal = "none"
        print("lce: no run has a laser power: fitting the deformation alone", file=sys.stderr)
    if deformation != "none" and all(run.displacement is None for run in runs):
        deformation = "none"
        print("lce: no run has a displacement: fitting the thermal stage alone", file=sys.stderr)
    model = load_model(args.start) if args.start else default_model(thermal, deformation)
    for effect in args.effect:
        model = model.add(effect)
    ranges = {}
    for text in args.hold:
        key, _, bounds = text.partition("=")
        low, _, high = bounds.partition(",")
        try:
            ranges[key] = float(low), float(high)
        except ValueError:
            raise LceError(f"--hold {text}: expected TERM.PARAM=LOWER,UPPER") from None
    return model.configured(parse_settings(args.set)).hold(ranges).fix(args.fix)


def _intervals(result: FitResult, args: argparse.Namespace, bar: FitBar) -> list[str]:
    """What was asked for beside the standard errors, as lines."""
    from lce_analysis.identification.bootstrap import bootstrap
    from lce_analysis.identification.profile import profiles

    lines = []
    if args.profile:
        lines += ["", "Profile likelihoods, 95 %:", *(f"- {p.sentence}" for p in profiles(result.problem, bar))]
    if args.bootstrap > 0:
        drawn = bootstrap(result.problem, args.bootstrap, args.seed, bar)
        lines += ["", f"Bootstrap, 95 % of {len(drawn.draws)} draws:", *(f"- {s}" for s in drawn.sentences)]
    return lines


def _summary(result: FitResult) -> str:
    """Parameters with their standard errors, what is not determined, and the error of each run."""
    lines = []
    for v in result.model.values:
        if v.fixed:
            note = "fixed"
        elif v.determined is None:
            note = ""
        elif v.standard_error is not None:
            note = f"± {v.standard_error:.2g}"
        else:
            note = "not determined"
        lines.append(f"{v.key:24s} {v.value:12.6g} {v.unit:5s} {note}")
    if result.identifiability is not None:
        lines += ["", *(_strong_correlations(result))]
        if result.identifiability.sentences:
            lines += ["What the data leave open:", *(f"- {s}" for s in result.identifiability.sentences)]
    lines += ["", f"{'run':24s} {'T NRMSE':>8s} {'d NRMSE':>8s}"]
    for entry in result.model.fit["runs"]:
        cells = [
            f"{entry[k] * 100:7.2f}%" if k in entry else "       –" for k in ("temperature_nrmse", "displacement_nrmse")
        ]
        lines.append(f"{entry['name']:24s} {cells[0]:>8s} {cells[1]:>8s}")
    return "\n".join(lines)


def _strong_correlations(result: FitResult, threshold: float = 0.95) -> list[str]:
    """Pairs of determined parameters that the data hardly tell apart."""
    report = result.identifiability
    assert report is not None
    known = [i for i, ok in enumerate(report.determined) if ok]
    pairs = [
        f"{report.keys[i]} and {report.keys[j]} ({report.correlation[i, j]:+.3f})"
        for i in known
        for j in known
        if i < j and abs(report.correlation[i, j]) > threshold
    ]
    return [f"Strongly correlated: {', '.join(pairs)}."] if pairs else []
