# SPDX-License-Identifier: Apache-2.0
"""The report of `lce add`: an effect added, and the errors of the model as given, refitted, and with it."""

from collections.abc import Collection

from lce_analysis.comparison.compare import Comparison
from lce_analysis.diagnosis import Addition
from lce_report.blocks import Block, Section
from lce_report.figures.before_after import overlays
from lce_report.figures.errors import error_reductions
from lce_report.figures.leading import StrengthByRun, strength_intervals
from lce_report.html.render import render
from lce_report.pages.footer import provenance
from lce_report.tables import AdditionTables


def render_addition(
    addition: Addition,
    tables: AdditionTables,
    strength: StrengthByRun,
    compared: dict[str, Comparison],
    held_out: Collection[str] = (),
) -> str:
    """An added effect as one self-contained HTML file.

    Parameters
    ----------
    addition : the effect, and the record of the models tried.
    tables, strength : the same laid out, and its strength by run.
    compared : the model as given, refitted, and with the effect, beside the same runs, by what they are called.
    held_out : names of the runs that none was fitted to.

    Returns
    -------
    str
        The text of the file.
    """
    runs = next(iter(compared.values())).runs
    evidence: list[Block] = [
        tables.errors,
        strength_intervals(strength),
        *error_reductions(compared, held_out),
        tables.history,
    ]
    sections = [Section("The errors", evidence), *overlays(compared, held_out)]
    drive = next(iter(compared.values())).drive
    footer = provenance(addition.model, [each.run for each in runs], drive)
    return render(f"{addition.effect} added", [addition.sentence], sections, footer)
