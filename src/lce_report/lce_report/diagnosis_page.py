# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as a page: the answer, the candidates, the error before and after, and what is left."""

from collections.abc import Collection, Sequence

import numpy as np

from lce_analysis.comparison.compare import Comparison, Quantity, Stage, compare
from lce_analysis.diagnosis.addition import Addition
from lce_analysis.diagnosis.diagnosis import Diagnosis
from lce_analysis.diagnosis.structure import STRUCTURED, Dependence
from lce_analysis.prediction import DISTANCE
from lce_data.run import Run
from lce_report import Axis, Bars, Block, Curve, Grid, Group, Lines, Section, Table, falls, provenance, render
from lce_report.run_section import RESIDUAL

SHOWN = 3
"""Dependences of the rest that are drawn."""
LEAST = 0.005
"""Share of the error below which nothing is drawn."""
MODELLED = {"temperature": (Axis("temperature T", "°C"), 1.0), "displacement": (Axis("displacement d", "mm"), 1e3)}
"""Axis of an overlay, and the factor from the unit of a stage to it."""


def page(found: Diagnosis, runs: Sequence[Run], test_runs: Sequence[Run] = ()) -> str:
    """The diagnosis as one self-contained HTML page."""
    every = [*runs, *test_runs]
    before, after = compare(found.before, every), compare(found.model, every)
    sections = [
        Section("Candidates", _candidates(found)),
        Section("The error, before and after", [*_steps(found), *falls(before, after, {r.name for r in test_runs})]),
        Section("What is left", _rest(found)),
        *_overlays(before, after, {r.name for r in test_runs}),
    ]
    return render("Which effect is missing", found.sentences, sections, provenance(found.model, every, "model"))


def addition_page(addition: Addition, before: Comparison, after: Comparison, held_out: Collection[str]) -> str:
    """An added effect as one self-contained HTML page: the error before and after, by run and regime."""
    rows = [
        (
            " + ".join([entry["thermal"], entry["deformation"], *entry["effects"]]),
            *(
                "" if (x := entry[side][f"{q}_nrmse"]) is None else f"{x:.2%}"
                for side in ("train", "test")
                for q in ("temperature", "displacement")
            ),
            entry["verdict"],
        )
        for entry in addition.model.fit["history"]
    ]
    head = ("model", "train T", "train d", "test T", "test d", "verdict")
    sections = [
        Section(
            "The error, before and after", [*falls(before, after, held_out), Table("Models tried (NRMSE)", head, rows)]
        ),
        *_overlays(before, after, held_out),
    ]
    runs = [c.run for c in after.runs]
    return render(f"{addition.effect} added", [addition.sentence], sections, provenance(addition.model, runs, "model"))


def _candidates(found: Diagnosis) -> list[Block]:
    strong = sorted((s for s in found.scores if s.predicted_fall > LEAST), key=lambda s: -s.predicted_fall)
    rows = [
        (
            s.effect.name,
            s.effect.stage,
            f"{s.evidence:.4g}",
            f"{s.p_value:.1e}",
            f"{s.visibility:.1%}",
            f"{s.expected_strength:.3g} {s.effect.parameter(s.effect.strength).unit}".removesuffix(" 1"),
            f"{s.detectable:.2g}" if s.shown else "not at all",
            f"{s.predicted_fall:.1%}",
            ", ".join(found.aliases[s.effect.name]),
        )
        for s in found.scores
    ]
    head = (
        "effect",
        "stage",
        "evidence",
        "p",
        "visible",
        "expected strength",
        "would show from",
        "predicted fall",
        "looks like",
    )
    return [
        "Each effect alone, before anything was refitted. Evidence is the score test's χ² after the free parameters "
        "were projected out; visible is the part of the effect that they do not mask; an effect would show from the "
        "strength given.",
        Bars(
            "Fall of the squared error that the score test predicts",
            "1",
            [s.effect.name for s in strong],
            [Group("predicted fall", "model", np.array([s.predicted_fall for s in strong]))],
            digits=".1%",
        ),
        Table("The library", head, rows),
    ]


def _steps(found: Diagnosis) -> list[Block]:
    steps = [
        (s.added, ", ".join(s.alias_set[1:]), f"{s.predicted_fall:.1%}", f"{s.actual_fall:.1%}") for s in found.steps
    ]
    return [Table("Added", ("effect", "or", "predicted fall", "actual fall"), steps)] if steps else []


def _rest(found: Diagnosis) -> list[Block]:
    if len(found.rest) == 0:
        return ["Only one run was given: whether the rest repeats itself cannot be told."]
    left = [d for d in found.rest if d.share > LEAST]
    if not left:
        return ["Nothing that repeats itself: no quantity predicts any of the residual in runs that were left out."]
    figures = []
    for d in left[:SHOWN]:
        quantity: Quantity = "displacement" if d.column == DISTANCE else "temperature"
        axis, factor = RESIDUAL[quantity]
        if d.x.size > 1:
            curve = Curve("mean residual", d.curve * factor, "residual")
            figures.append(Lines(_against(d), Axis(d.covariate, d.unit), axis, d.x, [curve]))
    shares = np.array([d.share for d in left])
    return [
        "How much of the residual's variance a curve over each quantity predicts in runs that were left out. Noise "
        "gives nothing.",
        Bars("Predictable share of the rest", "1", [_against(d) for d in left], [Group("share", "residual", shares)],
             digits=".0%", mark=STRUCTURED),
        *([Grid(figures, (1,) * len(figures))] if figures else []),
    ]  # fmt: skip


def _against(d: Dependence) -> str:
    return f"{'d' if d.column == DISTANCE else 'T'} against {d.covariate}"


def _overlays(before: Comparison, after: Comparison, held_out: Collection[str]) -> list[Section]:
    sections = []
    for a, b in zip(before.runs, after.runs, strict=True):
        figures: list[Block] = []
        for x, y in zip(a.stages, b.stages, strict=True):
            figures += _overlay(x, y, a.run.name)
        note = " (held out)" if a.run.name in held_out else ""
        sections.append(Section(f"{a.run.name}{note}", figures))
    return sections


def _overlay(before: Stage, after: Stage, run: str) -> list[Block]:
    q = before.quantity
    (axis, scale), (residual_axis, fine) = MODELLED[q], RESIDUAL[q]
    time = Axis("time", "s")
    return [
        Lines(
            q,
            time,
            axis,
            before.time_s,
            [
                Curve("measured", before.measured * scale, "measured"),
                Curve("before", before.modelled * scale, "before", "dashed"),
                Curve("after", after.modelled * scale, "after"),
            ],
            linked=run,
        ),
        Lines(
            f"residual of the {q}",
            time,
            residual_axis,
            before.time_s,
            [
                Curve("before", before.residual * fine, "before"),
                Curve("after", after.residual * fine, "after"),
            ],
            linked=run,
        ),
    ]
