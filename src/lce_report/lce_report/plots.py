# SPDX-License-Identifier: Apache-2.0
"""Results as figures of matplotlib, ready for a paper: a comparison, a diagnosis.

    from lce_report import plots
    plots.comparison(lce.compare(model, runs)).savefig("compare.pdf")
    plots.diagnosis(lce.diagnose(model, runs, held_out)).savefig("diagnose.svg")

A figure is returned, neither shown nor saved: change its axes first if you like. :mod:`lce_report.paper` draws a single
figure of a report.
"""

import textwrap
from collections.abc import Mapping
from typing import Final

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lce_analysis.comparison.compare import Comparison
from lce_analysis.diagnosis import Diagnosis
from lce_analysis.diagnosis.diagnosis import Column
from lce_analysis.diagnosis.misfit import Misfit
from lce_data.channels import Channel
from lce_data.units import in_head
from lce_report.blocks import Lines, Role
from lce_report.figures.leading import LeadingCandidate, leading_candidates
from lce_report.figures.run import run_section
from lce_report.paper import COLOURS, SETTINGS, curves_of, draw_on

COLUMN_IN, PANEL_IN = 3.2, 1.25
"""Width of a run, and height of a panel."""
TITLE_CHARACTERS = 44
"""Longest line above a panel of that width."""
BARS: Final[Mapping[Column, Role]] = {"given": "quiet", "before": "before", "after": "after"}


def comparison(found: Comparison) -> Figure:
    """Each run beside the model: the power, and each sensor with its residual beside ±2 σ of its noise, over time.

    Returns
    -------
    matplotlib.figure.Figure
        A column for each run, whose panels share their time, and a row for each quantity; empty where a run lacks it.
    """
    columns = [
        {
            block.title: block
            for block in curves_of(run_section(run).blocks)
            if isinstance(block, Lines) and block.linked
        }
        for run in found.runs
    ]
    titles = list(dict.fromkeys(title for column in sorted(columns, key=len, reverse=True) for title in column))
    with rc_context(SETTINGS):
        figure = Figure(figsize=(COLUMN_IN * len(columns), PANEL_IN * len(titles) + 0.5), layout="constrained")
        grid = figure.subplots(len(titles), len(columns), sharex="col", sharey="row", squeeze=False)
        for run, column, panels in zip(found.runs, columns, grid.T, strict=True):
            for axes, title in zip(panels, titles, strict=True):
                if title in column:
                    draw_on(axes, column[title])
                    axes.set_title("")
                    axes.label_outer(remove_inner_ticks=True)
                else:
                    axes.axis("off")
            panels[0].set_title(run.run.name)
    return figure


def diagnosis(found: Diagnosis) -> Figure:
    """The errors of the three models in units of the noise, and the strength that each run wants of each effect.

    Returns
    -------
    matplotlib.figure.Figure
        The errors on the runs learnt from and on those held out; then a panel for each effect that was added or came
        close.
    """
    strengths = [c for c in leading_candidates(found) if c.strength is not None]
    tables = {"training": found.train.misfit, "held out": found.test.misfit}
    tables = {name: misfit for name, misfit in tables.items() if misfit["before"].total}
    with rc_context(SETTINGS):
        count = 1 + len(strengths)
        figure = Figure(figsize=(COLUMN_IN * min(count, 2), 2.3 * ((count + 1) // 2)), layout="constrained")
        panels = [figure.add_subplot((count + 1) // 2, min(count, 2), i + 1) for i in range(count)]
        _errors(panels[0], tables, ", ".join(a.label for a in found.accepted))
        for axes, candidate in zip(panels[1:], strengths, strict=True):
            _strength(axes, candidate)
    return figure


def _errors(axes: Axes, tables: Mapping[str, Mapping[Column, Misfit]], added: str) -> None:
    """Bars of the errors: a group for each sensor of each set of runs, a bar for each model."""
    labels: dict[Column, str] = {"given": "as given", "before": "refitted", "after": f"with {added}"}
    kept = [column for column in BARS if column != "after" or added]
    groups: list[tuple[str, Channel]] = [(name, c) for name, table in tables.items() for c in table["before"].total]
    place = np.arange(len(groups))
    for i, column in enumerate(kept):
        heights = [tables[name][column].rms[channel] for name, channel in groups]
        at = place + 0.8 * ((i + 0.5) / len(kept) - 0.5)
        axes.bar(at, heights, 0.8 / len(kept), color=COLOURS[BARS[column]], label=labels[column])
    axes.axhline(1.0, color="black", linewidth=0.6, linestyle="--")
    axes.set_xticks(place, [f"{channel.symbol}\n{name}" for name, channel in groups])
    axes.set_ylabel("RMS error [× noise]")
    axes.legend(fontsize=7, loc="upper left")


def _strength(axes: Axes, candidate: LeadingCandidate) -> None:
    """The strength that each run wants, with its standard error, beside that of all runs and the null value."""
    strength = candidate.strength
    assert strength is not None
    known = [(name, own) for name, own in zip(strength.runs, strength.by_run, strict=True) if own is not None]
    values, errors = np.array([own for _, own in known]).reshape(-1, 2).T
    axes.errorbar(np.arange(len(known)), values, errors, fmt="o", markersize=3.5, color=COLOURS["residual"], capsize=2)
    axes.axhline(strength.null, color=COLOURS["quiet"], linewidth=0.6)
    if strength.common is not None:
        value, error = strength.common
        axes.axhspan(value - error, value + error, color=COLOURS["after"], alpha=0.3, linewidth=0.0)
        axes.axhline(value, color=COLOURS["after"], linewidth=1.0, label="all runs")
        axes.legend(fontsize=7)
    axes.set_xticks(np.arange(len(known)), [name for name, _ in known], rotation=30, ha="right")
    axes.margins(x=0.15)
    axes.set_ylabel(in_head(strength.name, strength.unit))
    axes.set_title(textwrap.fill(candidate.outcome, TITLE_CHARACTERS), fontsize=8)
