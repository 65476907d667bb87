# SPDX-License-Identifier: Apache-2.0
"""Figures for paper: the curves of a report as SVG or PDF, in colours that the colour-blind tell apart.

>>> import numpy as np
>>> from lce_report import Axis, Curve, Lines
>>> time_s = np.linspace(0.0, 10.0, 101)
>>> curve = Curve("measured", 0.1 * time_s, "measured")
>>> figure = draw(Lines("displacement", Axis("time", "s"), Axis("d", "mm"), time_s, (curve,)))
>>> figure.axes[0].get_ylabel()
'd [mm]'
"""

from collections.abc import Sequence
from io import BytesIO
from typing import Any, Final, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lce_data.units import in_head
from lce_report.blocks import Block, Form, Grid, Lines, Loop, Role

Format = Literal["svg", "pdf"]
Limits = tuple[float, float]

COLOURS: Final[dict[Role, str]] = {
    "measured": "#7f7f7f",
    "model": "#d55e00",
    "residual": "#0072b2",
    "input": "#cc79a7",
    "heating": "#d55e00",
    "cooling": "#0072b2",
    "before": "#e69f00",
    "after": "#009e73",
    "quiet": "#b0b0b0",
}
"""The palette of Okabe and Ito."""
STYLES: Final[dict[Form, dict[str, Any]]] = {
    "line": {"linewidth": 1.0},
    "step": {"linewidth": 1.0, "drawstyle": "steps-post"},
    "dashed": {"linewidth": 1.0, "linestyle": "--"},
    "points": {"linestyle": "none", "marker": ".", "markersize": 1.5},
    "marked": {"linewidth": 1.0, "marker": "o", "markersize": 3.5},
}
SETTINGS: Final[dict[Any, Any]] = {
    "font.size": 8,
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "lce",
    "pdf.fonttype": 42,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
}
WIDTH_IN, HEIGHT_IN = 3.5, 2.3
"""A column of a journal."""


def curves_of(blocks: Sequence[Block]) -> list[Lines | Loop]:
    """The figures of some blocks that are drawn as curves, in the order in which a page shows them."""
    found: list[Lines | Loop] = []
    for block in blocks:
        if isinstance(block, Lines | Loop):
            found.append(block)
        elif isinstance(block, Grid):
            for cell in block.figures:
                found += curves_of(cell if isinstance(cell, tuple) else (cell,))
    return found


def draw(block: Lines | Loop, x: Limits | None = None) -> Figure:
    """Draw a figure of a report.

    Parameters
    ----------
    x : the part of the x axis to show; all of it if None.

    Returns
    -------
    matplotlib.figure.Figure
        One pair of axes, to be changed or saved.
    """
    with rc_context(SETTINGS):
        figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), layout="constrained")
        draw_on(figure.add_subplot(), block)
        if x is not None:
            figure.axes[0].set_xlim(*x)
    return figure


def draw_on(axes: Axes, block: Lines | Loop) -> None:
    """Draw a figure of a report on axes that are there."""
    if isinstance(block, Lines):
        _draw_lines(axes, block)
    else:
        for trace in block.traces:
            axes.plot(trace.x, trace.y, color=COLOURS[trace.role], label=trace.label, **STYLES[trace.form])
    axes.set_xlabel(in_head(block.x_axis.name, block.x_axis.unit))
    axes.set_ylabel(in_head(block.y_axis.name, block.y_axis.unit))
    axes.set_title(block.title, fontsize=8)
    axes.set_xscale("log" if block.x_axis.log else "linear")
    axes.set_yscale("log" if block.y_axis.log else "linear")
    if block.y_axis.from_zero:
        axes.set_ylim(bottom=0.0)
    if len(axes.get_legend_handles_labels()[1]) > 1:
        axes.legend(fontsize=7)


def written(block: Lines | Loop, kind: Format, x: Limits | None = None) -> bytes:
    """The figure as a file; the same data give the same bytes."""
    file = BytesIO()
    metadata = {"Date": None} if kind == "svg" else {"CreationDate": None}
    with rc_context(SETTINGS):
        draw(block, x).savefig(file, format=kind, metadata=metadata)
    return file.getvalue()


def _draw_lines(axes: Axes, block: Lines) -> None:
    inside = [(at, text) for at, text in block.marks if block.x.size and block.x[0] <= at <= block.x[-1]]
    for at, text in inside:
        axes.axvline(at, color="black", linestyle="dashed", linewidth=0.6)
        said = text.replace("$", r"\$")  # else a formula
        axes.annotate(
            said,
            (at, 0.99),
            (2.0, 0.0),
            axes.get_xaxis_transform(),
            "offset points",
            fontsize=6,
            va="top",
            annotation_clip=True,
        )
    for curve in block.curves:
        if curve.low is not None and curve.high is not None:
            axes.fill_between(block.x, curve.low, curve.high, color=COLOURS[curve.role], alpha=0.2, linewidth=0.0)
        axes.plot(block.x, curve.y, color=COLOURS[curve.role], label=curve.label, **STYLES[curve.form])
    if any(np.nanmin(curve.y, initial=0.0) < 0.0 < np.nanmax(curve.y, initial=0.0) for curve in block.curves):
        axes.axhline(0.0, color=COLOURS["quiet"], linewidth=0.5, zorder=0)
