# SPDX-License-Identifier: Apache-2.0
"""Find the physical effect that a model lacks."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import lce_analysis.diagnosis as diagnosing
from lce_analysis.diagnosis import Diagnosis
from lce_analysis.identification.bounds import bounded
from lce_analysis.identification.identify import check_sensors
from lce_analysis.options import DiagnoseOptions
from lce_app.cluster import Cluster
from lce_app.use_cases.loading import load_model_and_effects, load_runs_and_tests
from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_model.effects import Effect, library
from lce_report.pages.diagnosis import render_diagnosis


@dataclass(frozen=True)
class Options:
    """How a model is diagnosed.

    Parameters
    ----------
    diagnosis : when an effect counts as missing.
    effects : effect files of the user's own, candidates beside the library.
    bounds : of the search, by TERM.PARAM, narrower or wider than by default, of the model and of the candidates.
    cluster : where fits run that do not depend on each other.
    """

    diagnosis: DiagnoseOptions = field(default_factory=DiagnoseOptions)
    effects: tuple[str, ...] = ()
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    cluster: Cluster = field(default_factory=Cluster)


DEFAULTS = Options()


def diagnose(
    run_files: Sequence[Path],
    model_file: Path,
    test_files: Sequence[Path] = (),
    options: Options = DEFAULTS,
    json_file: Path | None = None,
    report_file: Path | None = None,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Diagnosis:
    """Find which effect of the library, if any, a model lacks to explain runs.

    Parameters
    ----------
    run_files : runs to learn from: bag folders, MCAP files or CSV files.
    model_file : as `lce fit` writes it.
    test_files : runs held out, on which the model is judged before and after.
    options : when an effect counts as missing, and where to compute.
    json_file, report_file : the record as JSON, and the evidence as one HTML file; not written if None.
    progress : called after each step.
    cancel : stops between two steps and raises Cancelled; nothing is written.

    Returns
    -------
    Diagnosis
        The verdict with its evidence.

    Raises
    ------
    LceError
        If a run, the model or an effect file cannot be used.

    Examples
    --------
    >>> from pathlib import Path
    >>> found = diagnose([Path("runs/pulse")], Path("model.yaml"), [Path("runs/prbs")])  # doctest: +SKIP
    >>> print(found.verdict)  # doctest: +SKIP
    """
    progress = watched(progress, cancel)
    model, named = load_model_and_effects(model_file, options.effects)
    runs, test_runs = load_runs_and_tests(run_files, test_files)
    model, candidates = bounded(model, [*library().values(), *_own(named)], options.bounds)
    if report_file:
        check_sensors(model, test_runs)  # the report compares each run by itself
    with options.cluster.used():
        diagnosis = diagnosing.diagnose(model, runs, test_runs, candidates, options.diagnosis, progress)
    report = render_diagnosis(diagnosis, runs, test_runs, options.diagnosis) if report_file else ""
    if json_file:
        write_atomically(json_file, json.dumps(diagnosis.as_json(), indent=1, allow_nan=False) + "\n")
    if report_file:
        write_atomically(report_file, report)
    return diagnosis


def _own(named: Iterable[Effect]) -> list[Effect]:
    """The effects that are not of the library, each once. Raises LceError if one has the name of another."""
    own = {effect.reference: effect for effect in named if effect.path}
    known = dict.fromkeys(library(), "an effect of the library")
    for reference, effect in own.items():
        if effect.name in known:
            raise LceError(f"{reference}: its name {effect.name} is that of {known[effect.name]}; give it another")
        known[effect.name] = reference
    return list(own.values())
