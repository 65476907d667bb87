# SPDX-License-Identifier: Apache-2.0
"""What the tabs draw, as blocks of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from lce_analysis.diagnosis import effect_signature
from lce_app.workbench.live_series import WANTED
from lce_app.workbench.records import AdditionRecord, DiagnosisRecord
from lce_app.workbench.session import Role as Use
from lce_app.workbench.snapshot import Snapshot
from lce_app.workbench.state import WorkbenchState
from lce_data.channels import POWER, SENSORS, Channel, in_order
from lce_data.run import Floats, Run, Series
from lce_model import Model
from lce_report import Axis, Block, Curve, Figure, Grid, Lines, Table
from lce_report.blocks import Form, Role
from lce_report.figures.axes import TIME, residual_axis, title, value_axis
from lce_report.figures.errors import error_reductions
from lce_report.figures.leading import LeadingCandidate, candidate_grid, strength_intervals
from lce_report.pages.diagnosis import error_blocks, evidence_details

SIDES: Final[dict[Use, tuple[str, Role]]] = {"train": ("learnt from", "model"), "test": ("held out", "residual")}

PREPARED_ROLES: Final[tuple[Role, Role]] = ("measured", "model")


def diagnosis(found: DiagnosisRecord) -> Sequence[Block]:
    """The errors in three columns, what was added, and the ranking."""
    tables = (found.tables.ranking, found.tables.not_tried)
    return [*error_blocks(found.tables), *(table for table in tables if table)]


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
    """The residual of a run, and what the effect would change at the values given, all others as they are."""
    blocks: list[Block] = []
    for channel, found in effect_signature(model, run, effect, settings).items():
        axis, factor = residual_axis(channel), channel.difference.factor
        curves = (
            Curve("measured − model", found.residual * factor, "residual"),
            Curve(f"what {effect} would add to this model, nothing else refitted", found.change * factor, "after"),
        )
        name = f"{axis.name} of {run.name}, and {effect}"
        blocks.append(Lines(name, TIME, axis, found.time_s, curves, linked=f"{effect} {run.name}"))
    return blocks


def history(state: WorkbenchState) -> Sequence[Block]:
    """The models tried, and the RMS error of each as a table and as curves over their numbers."""
    numbers = [kept.number for kept in state.session.models]
    found = {n: {use: misfit.rms for use, misfit in state.misfits(n).items()} for n in numbers}
    columns = [(use, channel) for use in SIDES for channel in SENSORS if any(channel in found[n][use] for n in numbers)]
    head = ("model", *(f"{channel.symbol}, {SIDES[use][0]}" for use, channel in columns))
    rows = [
        (f"{n}", *(f"{rms:.3g}" if (rms := found[n][use].get(channel)) else "" for use, channel in columns))
        for n in numbers
    ]
    figures: list[Figure] = []
    for channel in dict.fromkeys(channel for _, channel in columns):
        curves = [
            Curve(label, np.array([found[n][use].get(channel, np.nan) for n in numbers]), role, "marked")
            for use, (label, role) in SIDES.items()
            if (use, channel) in columns
        ]
        name = f"RMS error of {title(channel)} by model, × noise"
        y_axis = Axis("RMS error, × noise", "1", from_zero=True)
        figures.append(
            Lines(name, Axis("model", "1", whole=True), y_axis, np.array(numbers, float), curves, height=190)
        )
    table = Table("RMS error of each model, × noise (1 is nothing but noise)", head, rows)
    return [table, Grid(figures, (1,) * len(figures))]


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


def preparation(recording: Run, run: Run | None) -> Sequence[Block]:
    """Every channel as it was recorded, and as it was prepared if it was."""
    blocks: list[Block] = []
    for channel in in_order({*recording.series, *(run.series if run else ())}):
        before = recording.series.get(channel)
        after = run.series.get(channel) if run is not None and run is not recording else None
        shown = {"as recorded": before} | ({"prepared": after} if after is not before else {})
        times = [series.time_s for series in shown.values() if series is not None]
        if not times:
            continue
        time_s = times[0] if len(times) == 1 else np.union1d(*times)
        form: Form = "step" if channel is POWER else "points" if channel in SENSORS and len(times) > 1 else "line"
        curves = [
            Curve(label, channel.display.from_si(_on(time_s, series, form)), role, form)
            for (label, series), role in zip(shown.items(), PREPARED_ROLES, strict=False)
            if series is not None
        ]
        blocks.append(
            Lines(title(channel), TIME, value_axis(channel), time_s, curves, marked_on(recording), height=180)
        )
    return blocks


def marked_on(run: Run) -> str:
    """The name by which the figures of a run that is prepared are linked."""
    return f"prepare {run.name}"


def _on(time_s: Floats, series: Series, form: Form) -> Floats:
    """A series at other times, its own among them: held, straight, or NaN in between."""
    if series.time_s.size == time_s.size:
        return series.value
    if form == "line":
        return np.interp(time_s, series.time_s, series.value, np.nan, np.nan)
    values = np.full(time_s.size, np.nan)
    if form == "step":
        here = (time_s >= series.time_s[0]) & (time_s <= series.time_s[-1])
        values[here] = series.value[np.searchsorted(series.time_s, time_s[here], "right") - 1]
    else:
        values[np.searchsorted(time_s, series.time_s)] = series.value
    return values


def course(measure: str) -> Sequence[Block]:
    """An empty figure for the number that the job under way reports."""
    none = np.empty(0)
    return [Lines(measure, TIME, Axis(measure, "σ"), none, (Curve(measure, none, "model"),), height=120)]


def live_topics(channel: Channel) -> tuple[str, ...]:
    """The topics of the live figure of a channel: what was measured, then what is wanted."""
    return (channel.topic, WANTED[channel][0]) if channel in WANTED else (channel.topic,)


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
