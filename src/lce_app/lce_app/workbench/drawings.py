# SPDX-License-Identifier: Apache-2.0
"""What the tabs draw, as blocks of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any, Final

import numpy as np

from lce_analysis.comparison.compare import QUANTITIES
from lce_analysis.prediction import Prediction, predict
from lce_app.workbench.bench import Workbench
from lce_app.workbench.session import Role as Use
from lce_app.workbench.snapshot import Heard
from lce_data.run import Floats, Run
from lce_model import Model
from lce_model.effects import library
from lce_report import Axis, Bars, Block, Curve, Figure, Grid, Group, Lines, falls
from lce_report.blocks import Role
from lce_report.run_section import NAMES, POWER, RESIDUAL, TIME, VALUE

SIDES: Final[dict[Use, tuple[str, Role]]] = {"train": ("learnt from", "model"), "test": ("held out", "residual")}


def candidates(diagnosis: Mapping[str, Any]) -> Sequence[Block]:
    """What each effect promises, strongest first."""
    strong = sorted(
        (c for c in diagnosis["candidates"] if c["predicted_fall"] > 0.005), key=lambda c: -c["predicted_fall"]
    )
    falls_by = Group("predicted fall", "model", np.array([c["predicted_fall"] for c in strong]))
    title = "Fall of the squared error that the score test predicts, each effect alone"
    return [Bars(title, "1", [c["effect"] for c in strong], [falls_by], ".1%")] if strong else []


def signature(model: Model, run: Run, effect: str, settings: Mapping[str, float]) -> Sequence[Block]:
    """The residual of a run, and what the effect at its expected strength would change, before any refit.

    The model is taken with the whole library at its null values, for which the diagnosis has compiled the code.
    """
    missing = [e.reference for e in library().values() if e.reference not in model.effects]
    whole = reduce(Model.add, missing, model)
    without, with_it = predict(whole, run), predict(whole.set(settings), run)
    blocks: list[Block] = []
    for quantity, measured, before, after in zip(
        QUANTITIES, (run.temperature, run.displacement), _series(without), _series(with_it), strict=True
    ):
        if measured is None or before is None or after is None:
            continue
        axis, factor = RESIDUAL[quantity]
        curves = (
            Curve("measured − model", (measured.value - before) * factor, "residual"),
            Curve(f"what {effect} would add before the refit", (after - before) * factor, "after"),
        )
        title = f"{axis.name} of {run.name}, and {effect}"
        blocks.append(Lines(title, TIME, axis, measured.time_s, curves, linked=f"{effect} {run.name}"))
    return blocks


def _series(prediction: Prediction) -> tuple[Any, Any]:
    return prediction.temperature_at_samples_k, prediction.displacement_at_samples_m


def history(bench: Workbench) -> Sequence[Block]:
    """The models tried, and their errors as curves over their numbers."""
    found = {kept.number: bench.errors(kept.number) for kept in bench.session.models}
    numbers = np.array([float(n) for n in found])
    figures: list[Figure] = []
    for quantity in QUANTITIES:
        curves = []
        for side, (label, role) in SIDES.items():
            values = [errors[side][f"{quantity}_nrmse"] for errors in found.values()]
            if any(v is not None for v in values):
                y = np.array([np.nan if v is None else 100.0 * v for v in values])
                curves.append(Curve(label, y, role, "marked"))
        if curves:
            name = f"NRMSE of {NAMES[quantity]} by model"
            figures.append(Lines(name, Axis("model", "1", whole=True), Axis("NRMSE", "%"), numbers, curves, height=190))
    return [Grid(figures, (1,) * len(figures))]


def before_and_after(bench: Workbench) -> Sequence[Block]:
    """The current model beside the one that it came from: by regime and by run."""
    if bench.session.current is None:
        return []
    parent = bench.session.kept(bench.session.current).parent
    after, before = bench.comparison(), bench.comparison(parent) if parent is not None else None
    if before is None or after is None:
        return []
    held_out = {run.name for run in bench.runs("test").values()}
    return [f"Model {parent} (before) and model {bench.session.current} (after).", *falls(before, after, held_out)]


def course(measure: str) -> Sequence[Block]:
    """An empty figure for the number that the job under way tells."""
    none = np.empty(0)
    return [Lines(measure, TIME, Axis(measure, "σ"), none, (Curve(measure, none, "model"),), height=120)]


LIVE: Final[Mapping[str, tuple[Axis, float, Mapping[str, tuple[str, Role]]]]] = {
    "temperature": (
        VALUE["temperature"][0],
        1.0,
        {"temperature": ("T", "model"), "temperature_setpoint": ("setpoint", "quiet")},
    ),
    "displacement": (
        VALUE["displacement"][0],
        1e3,
        {"displacement": ("d", "residual"), "target_displacement": ("target", "quiet")},
    ),
    "laser power": (
        POWER,
        1.0,
        {"laser/power": ("P", "input"), "laser/power_command": ("command", "quiet")},
    ),
}
"""Live figures: axis, factor from the topics' units, and the topics."""


def live() -> Sequence[Block]:
    """Empty figures for what the topics say."""
    none = np.empty(0)
    figures = [
        Lines(title, TIME, axis, none, [Curve(label, none, role) for label, role in curves.values()], height=170)
        for title, (axis, _, curves) in LIVE.items()
    ]
    return [Grid(figures, (1, 1, 1))]


def live_columns(heard: Sequence[Heard], began_s: float) -> dict[str, list[list[float | None]]]:
    """What was heard, as columns of the live figures; None where a topic was silent."""
    columns: dict[str, list[list[float | None]]] = {}
    for title, (_, factor, curves) in LIVE.items():
        columns[title] = [[moment.time_s - began_s for moment in heard]]
        for topic in curves:
            values = [moment.values.get(topic) for moment in heard]
            columns[title].append([None if v is None else v * factor for v in values])
    return columns


def live_values(moment: Heard) -> str:
    """The values of a moment in words."""
    words = []
    for axis, factor, curves in LIVE.values():
        for topic, (label, _) in curves.items():
            if topic in moment.values:
                words.append(f"{label} {moment.values[topic] * factor:.3f} {axis.unit}")
    return " · ".join(words) or "silence on the topics"


def wave(name: str, time_s: Floats, power_w: np.ndarray) -> Sequence[Block]:
    """A waveform of the laser power."""
    return [Lines(name, TIME, POWER, time_s, (Curve("P", power_w, "input", "step"),), height=160)]
