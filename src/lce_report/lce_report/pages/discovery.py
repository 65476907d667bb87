# SPDX-License-Identifier: Apache-2.0
"""The report of `lce discover`: what the residual shows, what was found, the errors, and what was tried."""

from collections.abc import Sequence
from typing import Final

from lce_analysis.comparison.compare import compare
from lce_analysis.comparison.predictive_check import predictive_check
from lce_analysis.discovery import Discovery
from lce_analysis.options import CompareOptions
from lce_data.progress import Progress, silent
from lce_data.run import Run
from lce_report.blocks import Block, Section
from lce_report.discovery_tables import discovery_tables
from lce_report.figures.before_after import overlays
from lce_report.figures.closures import found_function, overview
from lce_report.figures.errors import error_reductions
from lce_report.figures.predictive_check import predictive_check_section
from lce_report.figures.random_walk import random_walk
from lce_report.figures.signatures import signature_blocks
from lce_report.html.render import render
from lce_report.pages.footer import provenance

WHAT_WAS_FOUND: Final = "What was found"
"""Heading of the section with the curves."""
ABOUT_OVERVIEW: Final = (
    "Every function was examined with one step of its curve and without a refit, the free parameters of the model "
    "projected out. Functions of the same row or column often promise the same, because what they depend on moves "
    "together in these runs; the strongest that differ were refitted, if chance does not explain them. Of a covariate "
    "with a lag the likeliest time constant is shown. Point at a cell for the evidence."
)
FRAMED: Final = "What was found has a frame."


def render_discovery(
    found: Discovery, runs: Sequence[Run], test_runs: Sequence[Run] = (), progress: Progress = silent
) -> str:
    """A discovery as one self-contained HTML file.

    Parameters
    ----------
    found : what was found, with its evidence.
    runs, test_runs : those it was found from, and those held out.
    progress : called after each simulation of the predictive check.

    Returns
    -------
    str
        The text of the file.

    Raises
    ------
    LceError
        If a run does not hold what the models need.
    """
    every, held_out = [*runs, *test_runs], {run.name for run in test_runs}
    models = {"as given": found.given, "refitted": found.before}
    if found.found:
        models["as found"] = found.model
    options = CompareOptions(drive=found.drive)
    compared = {label: compare(model, every, options) for label, model in models.items()}
    check = predictive_check(found.model, test_runs or runs, runs, options=options, progress=progress)
    sections = [
        *discovery_sections(found, error_reductions(compared, held_out)),
        predictive_check_section(check),
        *overlays(compared, held_out),
    ]
    title = "What no library holds"
    return render(title, found.sentences, sections, provenance(found.model, every, found.drive))


def discovery_sections(found: Discovery, errors: Sequence[Block] = ()) -> list[Section]:
    """The evidence of a discovery that needs no run: what the report and the page both show.

    errors : figures to show beside the table of the errors.
    """
    tables = discovery_tables(found)
    tried: list[Block] = [tables.tried] if tables.tried else []
    if found.examinations:
        about = f"{ABOUT_OVERVIEW} {FRAMED}" if found.found else ABOUT_OVERVIEW
        tried += [about, *(overview(examination, found.found) for examination in found.examinations)]
    sections = [
        Section("What the residual shows", signature_blocks(found.signatures, advice=False)),
        Section(WHAT_WAS_FOUND, [block for one in found.found for block in found_function(one)]),
        Section("The formulas", [tables.formulas] if tables.formulas else []),
        Section("The errors", [tables.errors, *errors]),
        Section("What was tried", tried),
        Section("What would have to change during the runs", [b for walk in found.walks for b in random_walk(walk)]),
    ]
    return [section for section in sections if section.blocks]
