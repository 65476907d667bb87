# SPDX-License-Identifier: Apache-2.0
"""The report of `lce diagnose`: the answer, the candidates, the error before and after, and what is left."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from lce_analysis.comparison.compare import compare
from lce_analysis.diagnosis import Diagnosis
from lce_analysis.diagnosis.score import Score
from lce_analysis.diagnosis.structure import Dependence
from lce_analysis.options import DiagnoseOptions
from lce_data.run import Run
from lce_report.blocks import Axis, Bars, Block, Curve, Grid, Group, Lines, Section, Table
from lce_report.figures.axes import residual_axis
from lce_report.figures.before_after import overlays
from lce_report.figures.errors import error_reductions
from lce_report.html.render import render
from lce_report.pages.footer import provenance

SHOWN: Final = 3
"""Dependences of the rest that are drawn."""
LEAST: Final = 0.005
"""Share of the error below which nothing is drawn."""
LIBRARY_HEAD: Final = (
    "effect",
    "stage",
    "evidence",
    "p",
    "visible",
    "expected strength",
    "would show from",
    "predicted reduction",
    "looks like",
)
ABOUT_CANDIDATES: Final = (
    "Each effect alone, before anything was refitted. Evidence is the score test's χ² after the free parameters "
    "were projected out; visible is the part of the effect that they do not mask; an effect would show from the "
    "strength given."
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
    before, after = compare(found.before, every), compare(found.model, every)
    sections = [
        Section("Candidates", _candidates(found)),
        Section("The error, before and after", [*_steps(found), *error_reductions(before, after, held_out)]),
        Section("What is left", _rest(found.rest, options.structured)),
        *overlays(before, after, held_out),
    ]
    return render("Which effect is missing", found.sentences, sections, provenance(found.model, every))


def predicted_reductions(reductions: Mapping[str, float]) -> Bars:
    """The reduction of the squared error that each effect alone promises, by its name; those above LEAST are drawn."""
    strong = sorted((name for name in reductions if reductions[name] > LEAST), key=lambda name: -reductions[name])
    group = Group("predicted reduction", "model", np.array([reductions[name] for name in strong]))
    return Bars("Reduction of the squared error that the score test predicts", "1", strong, [group], digits=".1%")


def _candidates(found: Diagnosis) -> list[Block]:
    return [
        ABOUT_CANDIDATES,
        predicted_reductions({s.effect.name: s.predicted_reduction for s in found.scores}),
        Table("The library", LIBRARY_HEAD, [_candidate(s, found.aliases[s.effect.name]) for s in found.scores]),
    ]


def _candidate(score: Score, aliases: Sequence[str]) -> tuple[str, ...]:
    unit = score.effect.parameter(score.effect.strength).unit
    return (
        score.effect.name,
        score.effect.stage,
        f"{score.evidence:.4g}",
        f"{score.p_value:.1e}",
        f"{score.visibility:.1%}",
        f"{score.expected_strength:.3g} {unit}".removesuffix(" 1"),
        f"{score.detectable:.2g}" if score.shown else "not at all",
        f"{score.predicted_reduction:.1%}",
        ", ".join(aliases),
    )


def _steps(found: Diagnosis) -> list[Block]:
    if not found.steps:
        return []
    rows = [
        (s.added, ", ".join(s.alias_set[1:]), f"{s.predicted_reduction:.1%}", f"{s.actual_reduction:.1%}")
        for s in found.steps
    ]
    return [Table("Added", ("effect", "or", "predicted reduction", "actual reduction"), rows)]


def _rest(dependences: Sequence[Dependence], structured: float) -> list[Block]:
    if not dependences:
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
