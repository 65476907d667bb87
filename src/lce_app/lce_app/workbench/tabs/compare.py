# SPDX-License-Identifier: Apache-2.0
"""Where the model fails: shares of the error, and a run beside the model; a click on a share lights its samples up."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, get_args

import numpy as np
from nicegui import ui

from lce_analysis.comparison.conditions import BRANCHES, ErrorShares, Flags, OperatingConditions, spans
from lce_app.workbench.figures import Figures
from lce_app.workbench.memory import remember, remembered
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.texts import heading
from lce_data.channels import channel_named
from lce_report import Block
from lce_report.figures.errors import misfit, where
from lce_report.figures.run import Colouring, run_section
from lce_report.figures.several_models import several_models

if TYPE_CHECKING:
    from lce_analysis.comparison.compare import Comparison

Spans = dict[str, list[tuple[float, float]]]


def fill(state: WorkbenchState) -> None:
    """The answer, the table of shares, and the figures of the run chosen."""
    runs = state.used()
    names = list(runs)
    if state.session.current is None or not names:
        ui.label("A model and a run are needed. Fit a model on the tab Add, and choose runs on the tab Runs.")
        return

    def light(pick: str, row: int, column: int) -> None:
        """Light the cell's samples up; a run that has some is shown."""
        comparison = state.comparison()
        if comparison is None:
            return
        picked = picked_samples(comparison, pick, row, column)
        figures.light(picked)
        with_some = [name for name, run in runs.items() if picked[run.name]]
        if with_some and chosen.value not in with_some:
            chosen.set_value(with_some[0])

    Figures(partial(shares, state), light).mark("shares")
    ui.label("Click on a share: its samples light up in every figure below. Point at it: their rms residual.")
    with ui.row().classes("line"):
        chosen = ui.select(names, value=remembered("run", names), label="Run").mark("chosen run")
        ways = list(get_args(Colouring))
        by = ui.select(ways, value=remembered("loop by", ways), label="Loop coloured by").mark("loop by")
    for key, choice in (("run", chosen), ("loop by", by)):
        choice.on_value_change(partial(remember, key))
    figures = Figures(lambda: run_figures(state, str(chosen.value), by.value or "nothing"))
    figures.mark("run figures")
    heading("Several models over this run")
    numbers = {kept.number: f"{kept.number}: {kept.how}" for kept in state.session.models}
    several = ui.select(numbers, value=_with_parent(state), multiple=True, label="Models").props("use-chips")
    several.classes("chosen").mark("models beside")
    beside = Figures(lambda: models_over_run(state, str(chosen.value), several.value)).mark("several models")
    several.on_value_change(beside.reload)
    chosen.on_value_change(beside.reload)
    for choice in (chosen, by):
        choice.on_value_change(figures.reload)


def _with_parent(state: WorkbenchState) -> list[int]:
    """The current model, and in front of it the one that it came from."""
    assert state.session.current is not None
    kept = state.session.kept(state.session.current)
    return [kept.number] if kept.parent is None else [kept.parent, kept.number]


def models_over_run(state: WorkbenchState, name: str, numbers: Sequence[int]) -> Sequence[Block]:
    """Models of the history over one run."""
    run = state.used().get(name)
    models = {f"model {number}": model for number in sorted(numbers) if (model := state.model(number)) is not None}
    return several_models(run, models) if run is not None and models else []


def shares(state: WorkbenchState) -> Sequence[Block]:
    """The answer in words, the misfit, and where the error sits."""
    comparison = state.comparison()
    if comparison is None:
        return []
    return [
        *comparison.sentences,
        *(where(channel, found) for channel, found in comparison.shares.items()),
        misfit(comparison),
    ]


def run_figures(state: WorkbenchState, name: str, loop_by: Colouring = "nothing") -> Sequence[Block]:
    """A run beside the model, as in the report."""
    comparison, run = state.comparison(), state.used().get(name)
    if comparison is None or run is None:
        return []
    return next(run_section(found, loop_by).blocks for found in comparison.runs if found.run.name == run.name)


def picked_samples(comparison: Comparison, pick: str, row: int, column: int) -> Spans:
    """The samples that a cell of a table of shares counts, as intervals of the time of each run.

    Parameters
    ----------
    pick : channel and table, as "displacement cycle"; empty if no cell is picked.
    row, column : of the cell.
    """
    found: Spans = {run.run.name: [] for run in comparison.runs}
    if not pick:
        return found
    name, table = pick.split()
    channel = channel_named(name)
    shares = comparison.shares[channel]
    for run in comparison.runs:
        if (compared := run.channels.get(channel)) is None:
            continue
        if table == "cycle":
            here = _in_cycle(shares, run.run.name, compared.conditions, row, column)
        else:
            here = _under_condition(shares, compared.conditions, row, column)
        found[run.run.name] = spans(compared.time_s, here)
    return found


def _under_condition(shares: ErrorShares, conditions: OperatingConditions, row: int, column: int) -> Flags:
    """Samples (n,) of a cell: rows are heating and cooling, ramp before hold; columns quarters of the temperature."""
    branch, held = BRANCHES[row // 2], bool(row % 2)
    quarters = [share for share in shares.conditions if (share.branch, share.held) == (branch, held)]
    return quarters[column].among(conditions)


def _in_cycle(shares: ErrorShares, run: str, conditions: OperatingConditions, row: int, column: int) -> Flags:
    """Samples (n,) of a cell: rows are runs, columns the cycles of all runs."""
    if run != list(shares.cycles)[row]:
        return np.zeros(conditions.cycle.shape, dtype=np.bool_)
    cycles = sorted({cycle for by_cycle in shares.cycles.values() for cycle in by_cycle})
    return np.asarray(conditions.cycle == cycles[column])
