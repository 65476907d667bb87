# SPDX-License-Identifier: Apache-2.0
"""The report of `lce diagnose`: the answer, the errors in three columns, the candidates, and what is left."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from lce_analysis.comparison.compare import compare
from lce_analysis.diagnosis import Diagnosis
from lce_analysis.diagnosis.structure import Dependence
from lce_analysis.options import CompareOptions, DiagnoseOptions
from lce_analysis.signatures import Signature
from lce_data.run import Run
from lce_report.blocks import Axis, Bars, Block, Curve, Details, Grid, Group, Lines, Section
from lce_report.figures.axes import residual_axis
from lce_report.figures.before_after import overlays
from lce_report.figures.errors import error_reductions
from lce_report.figures.leading import LeadingCandidate, candidate_blocks, leading_candidates
from lce_report.figures.signatures import signature_blocks
from lce_report.html.render import render
from lce_report.pages.footer import provenance
from lce_report.tables import DiagnosisTables, diagnosis_tables

SHOWN: Final = 3
"""Dependences of the rest that are drawn."""
LEAST: Final = 0.005
"""Share of the residual's variance below which a dependence is not drawn."""
ABOUT_EVIDENCE: Final = (
    "None of this decides, but for one thing: of what is hardly visible no name is given. Evidence is the score test's "
    "χ² after the free parameters were projected out, visible is the part of the effect that they do not mask, and an "
    "effect would show from the strength given. What was tried was chosen by the share of the error that it promised."
)
ABOUT_REST: Final = (
    "How much of the residual's variance a curve over each quantity predicts in runs that were left out. Noise "
    "gives nothing."
)


def render_diagnosis(
    found: Diagnosis,
    runs: Sequence[Run],
    test_runs: Sequence[Run] = (),
    options: DiagnoseOptions = DiagnoseOptions(),
) -> str:
    """A diagnosis as one self-contained HTML file.

    Parameters
    ----------
    found : the verdict with its evidence.
    runs, test_runs : those it was found from, and those held out.
    options : with which it was found; its thresholds are marked in the figures.

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
    if found.accepted:
        models["as changed" if len(found.accepted) > 1 else f"with {found.accepted[0].label}"] = found.model
    compared = {label: compare(model, every, CompareOptions(drive=found.drive)) for label, model in models.items()}
    tables = diagnosis_tables(found)
    sections = [
        Section("The errors", [*error_blocks(tables), *error_reductions(compared, held_out)]),
        Section("The candidates", candidates(tables, leading_candidates(found))),
        signature_section(found.signatures),
        Section("What is left", _rest(found.rest, len(found.runs), options.structured)),
        *overlays(compared, held_out),
    ]
    return render("Which effect is missing", found.sentences, sections, provenance(found.model, every, found.drive))


def signature_section(signatures: Sequence[Signature]) -> Section:
    """What the residual shows at once, with pictures."""
    return Section("Signatures of the residual", signature_blocks(signatures))


def error_blocks(tables: DiagnosisTables) -> list[Block]:
    """The errors of the three models, what each change did, and what differs from run to run."""
    return [tables.errors, *(table for table in (tables.steps, tables.varies) if table)]


def candidates(tables: DiagnosisTables, leaders: Sequence[LeadingCandidate]) -> list[Block]:
    """The ranking, its leaders in detail, and the evidence behind a click."""
    ranking: list[Block] = [tables.ranking] if tables.ranking else ["No effect was tried: none promised enough."]
    not_tried = [tables.not_tried] if tables.not_tried else []
    details = [block for candidate in leaders for block in candidate_blocks(candidate)]
    return [*ranking, *not_tried, *details, evidence_details(tables)]


def evidence_details(tables: DiagnosisTables) -> Details:
    """The score test of every candidate, behind a click."""
    return Details("Evidence, p-values and aliases of all candidates", [ABOUT_EVIDENCE, tables.evidence])


def _rest(dependences: Sequence[Dependence], runs: int, structured: float) -> list[Block]:
    if runs < 2:
        return ["Only one run was given, so the data cannot show whether the rest repeats itself."]
    left = [d for d in dependences if d.share > LEAST]
    if not left:
        return ["Nothing that repeats itself: no quantity predicts any of the residual in runs that were left out."]
    group = Group("share", "residual", np.array([d.share for d in left]))
    names = [_against(d) for d in left]
    bars = Bars("Predictable share of the rest", "1", names, [group], digits=".0%", mark=structured)
    curves = [_dependence(d) for d in left[:SHOWN] if d.x.size > 1]
    return [ABOUT_REST, bars, *([Grid(curves, (1,) * len(curves))] if curves else [])]


def _dependence(d: Dependence) -> Lines:
    curve = Curve("mean residual", d.curve * d.channel.difference.factor, "residual")
    return Lines(_against(d), Axis(d.covariate, d.unit), residual_axis(d.channel), d.x, [curve])


def _against(d: Dependence) -> str:
    return f"{d.channel.symbol} against {d.covariate}"
