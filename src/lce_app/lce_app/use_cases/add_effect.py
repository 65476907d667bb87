# SPDX-License-Identifier: Apache-2.0
"""Add an effect to a model and refit it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import lce_analysis.diagnosis as diagnosing
from lce_analysis.comparison.compare import compare
from lce_analysis.diagnosis import Addition
from lce_analysis.identification.bounds import bounded
from lce_analysis.identification.identify import check_sensors
from lce_analysis.options import CompareOptions, DiagnoseOptions
from lce_app.use_cases.loading import load_model_and_effects, load_runs_and_tests
from lce_data.files import write_atomically
from lce_data.progress import CancelToken, Progress, silent
from lce_model import save_model
from lce_report.figures.leading import StrengthByRun, strength_by_run
from lce_report.pages.addition import render_addition
from lce_report.tables import AdditionTables, addition_tables


@dataclass(frozen=True)
class Added:
    """The addition, and what reports show of it: its tables, and the strength of the effect by run."""

    addition: Addition
    tables: AdditionTables
    strength: StrengthByRun


def add_effect(
    effect: str,
    run_files: Sequence[Path],
    model_file: Path,
    out: Path,
    test_files: Sequence[Path] = (),
    options: DiagnoseOptions = DiagnoseOptions(),
    bounds: Mapping[str, tuple[float, float]] = MappingProxyType({}),
    report_file: Path | None = None,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Added:
    """Add an effect to a model, refit the model to runs, and write its file.

    Parameters
    ----------
    effect : a name of the library, or the path of an effect file.
    run_files : runs to fit to: bag folders, MCAP files or CSV files.
    model_file : model to which the effect is added, as `lce fit` writes it.
    out : model file to write.
    test_files : runs held out, on which the effect is judged.
    options : when an effect counts as confirmed.
    bounds : of the search, by TERM.PARAM, narrower or wider than by default, of the model and of the effect.
    report_file : the errors and the series as one HTML file; not written if None.
    progress : called after each step.
    cancel : stops between two steps and raises Cancelled; nothing is written.

    Returns
    -------
    Added
        The models as given, refitted and with the effect, and how they compare with each run.

    Raises
    ------
    LceError
        If a run, the model or the effect cannot be used, or the model has the effect already.

    Examples
    --------
    >>> from pathlib import Path
    >>> found = add_effect("creep", [Path("runs/pulse")], Path("m.yaml"), Path("m2.yaml"))  # doctest: +SKIP
    >>> print(found.addition.sentence)  # doctest: +SKIP
    """
    runs, test_runs = load_runs_and_tests(run_files, test_files)
    model, (chosen,) = bounded(*load_model_and_effects(model_file, [effect]), bounds)
    check_sensors(model, test_runs)  # each run is compared by itself
    addition = diagnosing.add_effect(model, chosen, runs, test_runs, options, progress, cancel)
    every, held_out = [*runs, *test_runs], frozenset(run.name for run in test_runs)
    drive = CompareOptions(drive=addition.model.fit["drive"])
    models = {"as given": addition.given, "refitted": addition.before, f"with {chosen.name}": addition.model}
    compared = {label: compare(model, every, drive) for label, model in models.items()}
    tables = addition_tables(addition, compared, held_out)
    strength = strength_by_run(chosen.name, addition.amplitude, addition.strength_by_run)
    if report_file:
        write_atomically(report_file, render_addition(addition, tables, strength, compared, held_out))
    save_model(addition.model, out)
    return Added(addition, tables, strength)
