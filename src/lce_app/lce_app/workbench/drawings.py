# SPDX-License-Identifier: Apache-2.0
"""What the tabs draw, as blocks of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from lce_analysis.diagnosis import effect_signature
from lce_app.workbench.colours import colour
from lce_app.workbench.records import AdditionRecord, DiagnosisRecord
from lce_app.workbench.session import Role as Use
from lce_app.workbench.snapshot import WANTED, Snapshot
from lce_app.workbench.state import WorkbenchState
from lce_data.channels import POWER, SENSORS, Channel
from lce_data.run import Floats, Run
from lce_model import Model
from lce_report import Axis, Block, Curve, Figure, Grid, Lines
from lce_report.blocks import Role
from lce_report.figures.axes import TIME, residual_axis, title, value_axis
from lce_report.figures.errors import error_reductions
from lce_report.figures.leading import LeadingCandidate, candidate_grid, strength_intervals
from lce_report.pages.diagnosis import error_blocks, evidence_details

SIDES: Final[dict[Use, tuple[str, Role]]] = {"train": ("learnt from", "model"), "test": ("held out", "residual")}


def diagnosis(found: DiagnosisRecord) -> Sequence[Block]:
    """The errors in three columns, what was added, and the ranking."""
    ranking = [found.tables.ranking] if found.tables.ranking else []
    return [*error_blocks(found.tables), *ranking]


def evidence(found: DiagnosisRecord) -> Sequence[Block]:
    """The score test of every candidate, behind a click."""
    return [evidence_details(found.tables)]


def leading(candidate: LeadingCandidate) -> Sequence[Block]:
    """What a candidate that was tried explains of the residual, and its strength by run."""
    return [candidate_grid(candidate)]


def addition(found: AdditionRecord) -> Sequence[Block]:
    """What adding an effect did."""
    return [found.sentence, found.tables.errors, strength_intervals(found.strength), found.tables.history]


def signature(model: Model, run: Run, effect: str, settings: Mapping[str, float]) -> Sequence[Block]:
    """The residual of a run, and what the effect at its expected strength would change, before any refit."""
    blocks: list[Block] = []
    for channel, found in effect_signature(model, run, effect, settings).items():
        axis, factor = residual_axis(channel), channel.difference.factor
        curves = (
            Curve("measured − model", found.residual * factor, "residual"),
            Curve(f"what {effect} would add before the refit", found.change * factor, "after"),
        )
        name = f"{axis.name} of {run.name}, and {effect}"
        blocks.append(Lines(name, TIME, axis, found.time_s, curves, linked=f"{effect} {run.name}"))
    return blocks


def history(state: WorkbenchState) -> Sequence[Block]:
    """The models tried, and their errors as curves over their numbers."""
    found = {kept.number: state.errors(kept.number) for kept in state.session.models}
    numbers = np.array([float(n) for n in found])
    figures: list[Figure] = []
    for channel in SENSORS:
        curves = []
        for side, (label, role) in SIDES.items():
            values = [errors[side][f"{channel.name}_nrmse"] for errors in found.values()]
            if any(v is not None for v in values):
                y = np.array([np.nan if v is None else 100.0 * v for v in values])
                curves.append(Curve(label, y, role, "marked"))
        if curves:
            name = f"NRMSE of {title(channel)} by model"
            figures.append(Lines(name, Axis("model", "1", whole=True), Axis("NRMSE", "%"), numbers, curves, height=190))
    return [Grid(figures, (1,) * len(figures))]


def before_and_after(state: WorkbenchState) -> Sequence[Block]:
    """The current model beside the one that it came from, by operating condition and by run."""
    if state.session.current is None:
        return []
    parent = state.session.kept(state.session.current).parent
    after, before = state.comparison(), state.comparison(parent) if parent is not None else None
    if before is None or after is None:
        return []
    held_out = {run.name for run in state.runs("test").values()}
    return [
        f"Model {parent} (before) and model {state.session.current} (after).",
        *error_reductions({"before": before, "after": after}, held_out),
    ]


def course(measure: str) -> Sequence[Block]:
    """An empty figure for the number that the job under way reports."""
    none = np.empty(0)
    return [Lines(measure, TIME, Axis(measure, "σ"), none, (Curve(measure, none, "model"),), height=120)]


def live() -> Sequence[Block]:
    """Empty figures for what the topics say, one for each channel."""
    none = np.empty(0)
    figures = []
    for channel in (*SENSORS, POWER):
        curves = [Curve(channel.symbol, none, colour(channel))]
        if channel in WANTED:
            curves.append(Curve(WANTED[channel][1], none, "quiet"))
        figures.append(Lines(live_title(channel), TIME, value_axis(channel), none, curves, height=170))
    return [Grid(figures, (1,) * len(figures))]


def live_title(channel: Channel) -> str:
    """What the live figure of a channel is called."""
    return "laser power" if channel is POWER else channel.name


def live_topics(channel: Channel) -> tuple[str, ...]:
    """The topics of the live figure of a channel: what was measured, then what is wanted."""
    return (channel.topic, WANTED[channel][0]) if channel in WANTED else (channel.topic,)


def live_columns(snapshots: Sequence[Snapshot], began_s: float) -> dict[str, list[list[float | None]]]:
    """The snapshots as columns of the live figures; None for a topic that was silent."""
    columns: dict[str, list[list[float | None]]] = {}
    for channel in (*SENSORS, POWER):
        columns[live_title(channel)] = [
            [snapshot.time_s - began_s for snapshot in snapshots],
            *(
                [_shown(channel, snapshot.values.get(topic)) for snapshot in snapshots]
                for topic in live_topics(channel)
            ),
        ]
    return columns


def live_values(snapshot: Snapshot) -> str:
    """The values of a snapshot in words."""
    words = []
    for channel in (*SENSORS, POWER):
        labels = channel.symbol, WANTED[channel][1] if channel in WANTED else ""
        for topic, label in zip(live_topics(channel), labels, strict=False):
            if (value := _shown(channel, snapshot.values.get(topic))) is not None:
                words.append(f"{label} {value:.3f} {channel.display.symbol}")
    return " · ".join(words) or "the topics are silent"


def _shown(channel: Channel, value: float | None) -> float | None:
    """A value of a message [recorded unit] in the unit of the axis."""
    return None if value is None else channel.display.from_si(channel.recorded.to_si(value))


def wave(name: str, time_s: Floats, power_w: np.ndarray) -> Sequence[Block]:
    """A waveform of the laser power."""
    return [Lines(name, TIME, value_axis(POWER), time_s, (Curve("P", power_w, "input", "step"),), height=160)]
