# SPDX-License-Identifier: Apache-2.0
"""Compare a model with recorded runs: where does it fail?"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import lce_analysis.comparison.compare as comparing
import lce_analysis.comparison.predictive_check as checking
from lce_analysis.comparison.predictive_check import PredictiveCheck
from lce_analysis.options import CompareOptions
from lce_analysis.prediction import excited
from lce_app.use_cases.loading import load_runs
from lce_data.files import write_atomically
from lce_data.progress import CancelToken, Progress, silent
from lce_model import load_model
from lce_report.pages.comparison import render_comparison


@dataclass(frozen=True)
class Compared:
    """The comparison, a sentence for each run that says little of the model, and the predictive check if asked for."""

    comparison: comparing.Comparison
    warnings: tuple[str, ...]
    check: PredictiveCheck | None = None


def compare(
    run_files: Sequence[Path],
    model_file: Path,
    options: CompareOptions = CompareOptions(),
    json_file: Path | None = None,
    report_file: Path | None = None,
    simulations: int = 0,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Compared:
    """Compare a model with every series of every run that it predicts.

    Parameters
    ----------
    run_files : bag folders, MCAP files or CSV files.
    model_file : as `lce fit` writes it.
    options : what drives the deformation, and from which size on a misfit counts.
    json_file, report_file : numbers in SI or °C as JSON, and figures as one HTML file; not written if None.
    simulations : of the predictive check, 20 or more; 0: none.
    progress : called after each run, and after each part of the simulations.
    cancel : stops between two runs and raises Cancelled; nothing is written.

    Returns
    -------
    Compared
        The comparison, and warnings.

    Raises
    ------
    LceError
        If a run or the model cannot be used.

    Examples
    --------
    >>> from pathlib import Path
    >>> found = compare([Path("runs/prbs")], Path("model.yaml"), report_file=Path("compare.html"))  # doctest: +SKIP
    >>> print(found.comparison.sentences[0])  # doctest: +SKIP
    """
    runs, model = load_runs(run_files), load_model(model_file)
    comparison = comparing.compare(model, runs, options, progress, cancel)
    check = None
    if simulations:
        check = checking.predictive_check(
            model, runs, draws=simulations, options=options, progress=progress, cancel=cancel
        )
    report = render_comparison(comparison, check) if report_file else ""
    if json_file:
        content = comparing.as_json(comparison) | {"predictive_check": check and checking.as_json(check)}
        write_atomically(json_file, json.dumps(content, allow_nan=False) + "\n")
    if report_file:
        write_atomically(report_file, report)
    dark = [run.name for run in runs if not excited(run)]
    return Compared(
        comparison, tuple(f"{name}: the laser power never changes; it says little of the model" for name in dark), check
    )
