# SPDX-License-Identifier: Apache-2.0
"""A diagnosis as a page: the answer, the candidates, the error before and after, and what is left."""

from collections.abc import Collection, Sequence

import numpy as np

from lce_analysis.compare import Comparison, Stage, compare
from lce_analysis.diagnose.addition import Addition
from lce_analysis.diagnose.diagnosis import Diagnosis
from lce_analysis.experiment import Run
from lce_analysis.predict import DISTANCE
from lce_analysis.report import Axis, Bars, Block, Curve, Grid, Group, Lines, Section, Table, provenance, render

SHOWN_DEPENDENCES = 3
MICRO = 1e6
AXES = {"temperature": Axis("temperature T", "°C"), "displacement": Axis("displacement d", "mm")}
RESIDUAL_AXES = {"temperature": Axis("residual of T", "K"), "displacement": Axis("residual of d", "µm")}
TO_AXIS = {"temperature": (1.0, 1.0), "displacement": (1e3, MICRO)}
"""Factors from the unit of a stage to the axes of the overlay and of the residual."""


def page(found: Diagnosis, runs: Sequence[Run], test_runs: Sequence[Run] = ()) -> str:
    """The diagnosis as one self-contained HTML page."""
    every = [*runs, *test_runs]
    before, after = compare(found.before, every), compare(found.model, every)
    sections = [
        Section("Candidates", _candidates(found)),
        Section("The error, before and after", [*_falls(before, after), *_steps(found)]),
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
        Section("The error, before and after", [*_falls(before, after), Table("Models tried (NRMSE)", head, rows)]),
        *_overlays(before, after, held_out),
    ]
    runs = [c.run for c in after.runs]
    return render(f"{addition.effect} added", [addition.sentence], sections, provenance(addition.model, runs, "model"))


def _candidates(found: Diagnosis) -> list[Block]:
    strong = [s for s in found.scores if s.evidence > 0.0]
    rows = [
        (
            s.effect.name,
            s.effect.stage,
            f"{s.evidence:.4g}",
            f"{s.p_value:.1e}",
            f"{s.visibility:.1%}",
            f"{s.expected_strength:.3g} {s.effect.parameter(s.effect.strength).unit}",
            f"{s.predicted_fall:.1%}",
            ", ".join(found.aliases[s.effect.name]),
        )
        for s in found.scores
    ]
    head = ("effect", "stage", "evidence", "p", "visible", "expected strength", "predicted fall", "looks like")
    return [
        "Each effect alone, before anything was refitted. Evidence is the score test's χ² after the free parameters "
        "were projected out; visible is the part of the effect that they do not mask.",
        Bars(
            "Fall of the squared error that the score test predicts",
            "1",
            [s.effect.name for s in strong],
            [Group("predicted fall", "model", np.array([s.predicted_fall for s in strong]))],
            digits=".1%",
        ),
        Table("The library", head, rows),
    ]


def _falls(before: Comparison, after: Comparison) -> list[Block]:
    blocks: list[Block] = []
    for quantity in ("temperature", "displacement"):
        pairs = [(a.run.name, x, y) for a, b in zip(before.runs, after.runs, strict=True)
                 for x, y in zip(a.stages, b.stages, strict=True) if x.quantity == quantity]  # fmt: skip
        if pairs:
            blocks.append(
                Bars(
                    f"Error of the {quantity}, in units of the sensor's noise",
                    "1",
                    [name for name, _, _ in pairs],
                    [
                        Group("before", "before", np.array([x.metrics.over_noise for _, x, _ in pairs])),
                        Group("after", "after", np.array([y.metrics.over_noise for _, _, y in pairs])),
                    ],
                    mark=1.0,
                )
            )
    return blocks


def _steps(found: Diagnosis) -> list[Block]:
    steps = [
        (s.added, ", ".join(s.alias_set[1:]), f"{s.predicted_fall:.1%}", f"{s.actual_fall:.1%}") for s in found.steps
    ]
    return [Table("Added", ("effect", "or", "predicted fall", "actual fall"), steps)] if steps else []


def _rest(found: Diagnosis) -> list[Block]:
    if not found.rest:
        return ["Only one run was given: whether the rest repeats itself cannot be told."]
    top = found.rest[:SHOWN_DEPENDENCES]
    figures = []
    for d in top:
        quantity = "displacement" if d.column == DISTANCE else "temperature"
        if d.x.size > 1:
            curve = Curve("mean residual", d.curve * TO_AXIS[quantity][1], "residual")
            figures.append(
                Lines(f"{d.share:.0%} of the rest", Axis(d.covariate, d.unit), RESIDUAL_AXES[quantity], d.x, [curve])
            )
    names = [f"{'d' if d.column == DISTANCE else 'T'} against {d.covariate}" for d in found.rest]
    shares = np.array([max(d.share, 0.0) for d in found.rest])
    return [
        "How much of the residual's variance a curve over each quantity predicts in runs that were left out. Noise "
        "gives nothing.",
        Bars("Predictable share of the rest", "1", names, [Group("share", "residual", shares)], digits=".0%"),
        Grid(figures, (1,) * len(figures)) if figures else "No quantity predicts any of it.",
    ]


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
    scale, fine = TO_AXIS[q]
    time = Axis("time", "s")
    return [
        Lines(
            q,
            time,
            AXES[q],
            before.time_s,
            [
                Curve("measured", before.measured * scale, "measured", "points"),
                Curve("before", before.modelled * scale, "before", "dashed"),
                Curve("after", after.modelled * scale, "after"),
            ],
            linked=run,
        ),
        Lines(
            f"residual of the {q}",
            time,
            RESIDUAL_AXES[q],
            before.time_s,
            [
                Curve("before", before.residual * fine, "before"),
                Curve("after", after.residual * fine, "after"),
            ],
            linked=run,
        ),
    ]
