# SPDX-License-Identifier: Apache-2.0
"""`lce fit`: identify a model from recorded runs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from lce_app.cli.arguments import (
    add_bounds,
    add_cluster,
    add_effect_files,
    add_runs,
    add_settings,
    bounds,
    check_inputs,
    check_outputs,
    settings,
)

if TYPE_CHECKING:
    from lce_app.use_cases.fit import FittedModel

EXAMPLES = (
    "lce fit runs/* --out m.yaml",
    "lce fit runs/* --out m.yaml --deformation dynamic --effect creep",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `lce fit`."""
    add_runs(parser)
    parser.add_argument("--out", type=Path, required=True, metavar="M.yaml", help="model file to write")
    parser.add_argument("--thermal", metavar="T", help="P→T model: lumped (default), hammerstein_wiener, none")
    parser.add_argument(
        "--deformation",
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
    parser.add_argument(
        "--start",
        type=Path,
        metavar="M0.yaml",
        help="model file to start from: its stages, its effects and its values; another --thermal or --deformation "
        "beside it is wrong usage",
    )
    add_effect_files(parser)
    add_settings(parser, "TERM.PARAM=V", "start from this value")
    parser.add_argument(
        "--varies",
        action="append",
        default=[],
        metavar="TERM.PARAM",
        help="let this parameter differ from run to run (ambient.t_env, lumped.gain, …)",
    )
    parser.add_argument("--fix", action="append", default=[], metavar="TERM.PARAM", help="do not fit this parameter")
    add_bounds(parser)
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
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of the random starts; the same seed gives the same result"
    )
    add_cluster(parser)


def main(args: argparse.Namespace) -> int:
    """Fit, print what was found, write the model file or files."""
    check_inputs(args.runs, [args.start])
    check_outputs(args.out)
    from lce_analysis.options import FitOptions
    from lce_app.cli.progress_bar import FitBar
    from lce_app.cluster import Cluster
    from lce_app.use_cases.fit import ModelChoice, Options, fit

    choice = ModelChoice(
        thermal=args.thermal,
        deformation=args.deformation,
        effects=tuple(args.effect),
        start=args.start,
        settings=settings(args),
        ranges=bounds(args),
        fixed=tuple(args.fix),
        varies=tuple(args.varies),
    )
    options = Options(
        search=FitOptions(drive=args.drive, seed=args.seed),
        per_run=args.per_run,
        profile=args.profile,
        bootstrap_draws=args.bootstrap,
        cluster=Cluster(args.backend, args.scheduler),
    )
    with FitBar() as bar:
        fits = fit(args.runs, args.out, choice, options, bar)
    for warning in fits.warnings:
        print(f"lce: {warning}", file=sys.stderr)
    for fitted in fits.models:
        lines = [fitted.result.summary(), *_differences(fitted), *_faults(fitted), *_intervals(fitted)]
        print("\n".join([*lines, "", str(fitted.file)]))
    if fits.interrupted:
        print("lce: interrupted; the model file holds the best values so far", file=sys.stderr)
        return 130
    return 0


def _differences(fitted: FittedModel) -> list[str]:
    """What differs from run to run, as lines of a table."""
    from lce_app.cli.table import as_text
    from lce_report.tables import values_by_run

    return ["", as_text(values_by_run(fitted.result.model))] if fitted.result.model.varies else []


def _faults(fitted: FittedModel) -> list[str]:
    """Parameters at a bound, and what the model does not describe, as lines."""
    lines = []
    if fitted.at_bounds:
        lines += ["", "At a bound:", *(f"- {bound.sentence}" for bound in fitted.at_bounds)]
    for judgement in fitted.judgements:
        lines += ["", *judgement.sentences]
    return lines


def _intervals(fitted: FittedModel) -> list[str]:
    """What was asked for beside the standard errors, as lines."""
    lines = []
    if fitted.profiles:
        lines += ["", "Profile likelihoods, 95 %:", *(f"- {p.sentence}" for p in fitted.profiles)]
    if fitted.bootstrap is not None:
        head = f"Bootstrap, 95 % of {len(fitted.bootstrap.draws)} draws:"
        lines += ["", head, *(f"- {sentence}" for sentence in fitted.bootstrap.sentences)]
    return lines
