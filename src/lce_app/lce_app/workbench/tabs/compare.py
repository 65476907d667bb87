# SPDX-License-Identifier: Apache-2.0
"""Where the model fails: the shares of the error, and a run beside the model; a share clicked lights its samples up."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, get_args

from nicegui import ui

from lce_analysis.comparison.conditions import BRANCHES, spans
from lce_app.workbench.bench import Workbench
from lce_app.workbench.figures import Figures
from lce_app.workbench.memory import remember, remembered
from lce_report import Block
from lce_report.comparison_page import misfit, where
from lce_report.run_section import Colouring, run_section

if TYPE_CHECKING:
    from lce_analysis.comparison.compare import Comparison, Quantity

Spans = dict[str, list[tuple[float, float]]]


def fill(bench: Workbench) -> None:
    """The answer, the table of shares, and the figures of the run chosen."""
    names = list(bench.used())
    if bench.session.current is None or not names:
        ui.label("A model and a run are needed. Fit a model on the tab Add, and choose runs on the tab Runs.")
        return

    def light(pick: str, row: int, column: int) -> None:
        """Light the cell's samples up; a run that has some is shown."""
        comparison = bench.comparison()
        if comparison is None:
            return
        spans = lit(comparison, pick, row, column)
        figures.light(spans)
        with_some = [name for name in names if (run := bench.entries[name].run) is not None and spans[run.name]]
        if with_some and chosen.value not in with_some:
            chosen.set_value(with_some[0])

    Figures(partial(shares, bench), light).mark("shares")
    ui.label("Click on a share: its samples light up in every figure below. Point at it: their rms residual.")
    with ui.row().classes("line"):
        chosen = ui.select(names, value=remembered("run", names), label="Run").mark("chosen run")
        ways = list(get_args(Colouring))
        by = ui.select(ways, value=remembered("loop by", ways), label="Loop coloured by").mark("loop by")
    for key, choice in (("run", chosen), ("loop by", by)):
        choice.on_value_change(partial(remember, key))
    figures = Figures(lambda: run_figures(bench, str(chosen.value), by.value or "nothing"))
    figures.mark("run figures")
    for choice in (chosen, by):
        choice.on_value_change(figures.reload)


def shares(bench: Workbench) -> Sequence[Block]:
    """The answer in words, the misfit, and where the error sits."""
    comparison = bench.comparison()
    if comparison is None:
        return []
    return [*comparison.sentences, *(where(q, s) for q, s in comparison.shares.items()), misfit(comparison)]


def run_figures(bench: Workbench, name: str, loop_by: Colouring = "nothing") -> Sequence[Block]:
    """A run beside the model, as in the report."""
    comparison, run = bench.comparison(), bench.entries[name].run
    if comparison is None:
        return []
    return next(run_section(found, loop_by).blocks for found in comparison.runs if found.run is run)


def lit(comparison: Comparison, pick: str, row: int, column: int) -> Spans:
    """The samples of a cell of a table of shares, as stretches of the time of each run."""
    found: Spans = {run.run.name: [] for run in comparison.runs}
    if not pick:
        return found
    name, by = pick.split()
    quantity: Quantity = "temperature" if name == "temperature" else "displacement"
    shares = comparison.shares[quantity]
    for run in comparison.runs:
        if (stage := run.stage(quantity)) is None:
            continue
        if by == "regime":
            branch, held = BRANCHES[row // 2], bool(row % 2)
            (share,) = [s for s in shares.regimes if (s.branch, s.held) == (branch, held)][column : column + 1]
            here = share.among(stage.regime)
        else:
            cycles = sorted({n for by_cycle in shares.cycles.values() for n in by_cycle})
            here = (stage.regime.cycle == cycles[column]) & (run.run.name == list(shares.cycles)[row])
        found[run.run.name] = spans(stage.time_s, here)
    return found
