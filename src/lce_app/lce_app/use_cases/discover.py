# SPDX-License-Identifier: Apache-2.0
"""Find what no effect of the library holds, and write it down as an effect."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import lce_analysis.discovery as discovering
from lce_analysis.discovery import Discovery
from lce_analysis.identification.bounds import bounded
from lce_analysis.options import DiscoverOptions
from lce_app.use_cases.loading import load_runs_and_tests
from lce_data.errors import LceError
from lce_data.files import write_atomically
from lce_data.progress import CancelToken, Progress, silent, watched
from lce_model import load_model


@dataclass(frozen=True)
class Options:
    """How an unknown function is searched for.

    Parameters
    ----------
    discovery : what is tried, and when it counts as found.
    bounds : of the search, by TERM.PARAM of the model, narrower or wider than by default.
    """

    discovery: DiscoverOptions = field(default_factory=DiscoverOptions)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)


DEFAULTS = Options()


@dataclass(frozen=True)
class Written:
    """What was found, and where it was written.

    effects : an effect file for each function; empty if none was found.
    rivals : the file with the next formula that describes a function as well, by the file of the function.
    """

    discovery: Discovery
    effects: tuple[Path, ...]
    rivals: Mapping[Path, Path]


def discover(
    run_files: Sequence[Path],
    model_file: Path,
    out: Path,
    test_files: Sequence[Path] = (),
    options: Options = DEFAULTS,
    json_file: Path | None = None,
    report_file: Path | None = None,
    progress: Progress = silent,
    cancel: CancelToken | None = None,
) -> Written:
    """Find an unknown function that a model lacks to explain runs, and write it as an effect file.

    Parameters
    ----------
    run_files : runs to learn from: bag folders, MCAP files or CSV files.
    model_file : as `lce fit` writes it.
    out : the effect file, ``*.py``; a second function goes beside it, with _2 behind its name, and the next formula
        of a function, if the data cannot tell it from the first, with _or.
    test_files : runs held out, which decide whether a function is worth having.
    options : what is tried.
    json_file, report_file : the record as JSON, and the evidence as one HTML file; not written if None.
    progress : called after each step.
    cancel : stops between two steps and raises Cancelled; nothing is written.

    Returns
    -------
    Written
        What was found, and where it was written.

    Raises
    ------
    LceError
        If a run, the model, or the name of the effect file cannot be used.

    Examples
    --------
    >>> from pathlib import Path
    >>> found = discover([Path("runs/pulse")], Path("model.yaml"), Path("found.py"))  # doctest: +SKIP
    >>> print(found.discovery.verdict, found.effects)  # doctest: +SKIP
    """
    if out.suffix != ".py":
        raise LceError(f"{out}: an effect file must end in .py")
    progress = watched(progress, cancel)
    model, (runs, test_runs) = load_model(model_file), load_runs_and_tests(run_files, test_files)
    model, _ = bounded(model, (), options.bounds)
    found = discovering.discover(model, runs, test_runs, options.discovery, progress)
    report = ""
    if report_file:
        from lce_report.pages.discovery import render_discovery

        report = render_discovery(found, runs, test_runs, progress)
    files = [out, *(out.with_stem(f"{out.stem}_{i}") for i in range(2, len(found.found) + 1))][: len(found.found)]
    rivals = {}
    for path, one in zip(files, found.found, strict=True):
        write_atomically(path, one.effect_file(found.runs))
        if rival := one.rival_file(found.runs):
            rivals[path] = path.with_stem(f"{path.stem}_or")
            write_atomically(rivals[path], rival)
    if json_file:
        write_atomically(json_file, json.dumps(found.as_json(), indent=1) + "\n")
    if report_file:
        write_atomically(report_file, report)
    return Written(found, tuple(files), rivals)
