# SPDX-License-Identifier: Apache-2.0
"""HTML of blocks; what a script draws is described beside it as plain numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lce_report.blocks import Axis, Bars, Block, Curve, Details, Grid, Heat, Intervals, Lines, Loop, Table, Trace
from lce_report.html.arrays import Arrays, Floats, Indices, Samples, distinct, visible
from lce_report.html.description import (
    CurveDescription,
    FigureDescription,
    LinesDescription,
    LoopDescription,
    TraceDescription,
)
from lce_report.html.templates import templates

if TYPE_CHECKING:
    from markupsafe import Markup


class Fragment:
    """HTML of blocks; what the script draws gathers in ``figures`` and ``arrays``.

    Parameters
    ----------
    arrays : takes the numbers. With Samples, curves keep every sample, and the cells of a table that has something to
        pick are buttons; with Arrays, what the eye cannot see is left out.

    Attributes
    ----------
    figures : description of each figure for figures.js, by the number in its ``data-figure``.
    """

    def __init__(self, arrays: Arrays | Samples) -> None:
        self.figures: list[LinesDescription | LoopDescription] = []
        self.arrays = arrays
        self._answers = isinstance(arrays, Samples)
        # Any: its attributes are the macros of the template, which have no types.
        self._html: Any = templates().get_template("blocks.html").module

    def block(self, block: Block) -> Markup:
        """The HTML of one block, its texts escaped."""
        match block:
            case str():
                html = self._html.paragraph(block)
            case Grid():
                stacks = [f if isinstance(f, tuple) else (f,) for f in block.figures]
                columns = [f"minmax(0, {width}fr)" for width in block.widths]
                html = self._html.grid(columns, [[self.block(figure) for figure in stack] for stack in stacks])
            case Lines() | Loop():
                html = self._html.figure(len(self.figures), block.title)
                self.figures.append(self._figure(block))
            case Heat():
                html = self._html.heat(block, _heat_cells(block), block.pick if self._answers else "")
            case Bars():
                html = self._html.bars(block, *_bars(block))
            case Intervals():
                html = self._html.intervals(block, *_intervals(block))
            case Details():
                html = self._html.details(block.summary, [self.block(inner) for inner in block.blocks])
            case Table():
                html = self._html.table(block, block.numeric)
        return html

    def _figure(self, block: Lines | Loop) -> LinesDescription | LoopDescription:
        figure: FigureDescription = {
            "title": block.title,
            "xAxis": vars(block.x_axis),
            "yAxis": vars(block.y_axis),
            "linked": block.linked,
            "height": block.height,
        }
        if isinstance(block, Loop):
            return {**figure, "traces": [self._trace(trace) for trace in block.traces]}
        edges = [e for c in block.curves for e in (c.y, c.low, c.high) if e is not None]
        keep = np.arange(block.x.size) if self._answers else visible(edges)
        x = self.arrays.add(_scaled(block.x[keep], block.x_axis))
        curves = [self._curve(curve, keep, block.y_axis) for curve in block.curves]
        return {**figure, "x": x, "curves": curves, "marks": list(block.marks)}

    def _curve(self, curve: Curve, keep: Indices, axis: Axis) -> CurveDescription:
        """The samples ``keep`` of a curve."""
        y = self.arrays.add(_scaled(curve.y[keep], axis))
        described: CurveDescription = {"label": curve.label, "role": curve.role, "form": curve.form, "y": y}
        if curve.low is not None:
            described["low"] = self.arrays.add(_scaled(curve.low[keep], axis))
        if curve.high is not None:
            described["high"] = self.arrays.add(_scaled(curve.high[keep], axis))
        return described

    def _trace(self, trace: Trace) -> TraceDescription:
        keep = distinct(trace.x, trace.y, joined=trace.form != "points")
        x, y = self.arrays.add(trace.x[keep]), self.arrays.add(trace.y[keep])
        described: TraceDescription = {
            "label": trace.label,
            "role": trace.role,
            "form": trace.form,
            "x": x,
            "y": y,
        }
        if trace.at is not None:
            described["at"] = self.arrays.add(trace.at[keep])
        return described


def _scaled(values: Floats, axis: Axis) -> Floats:
    """The numbers as the page gets them: logarithms for a logarithmic axis, so that small ones keep their digits."""
    return np.log10(values) if axis.log else values


def _heat_cells(heat: Heat) -> list[list[dict[str, str | bool | None]]]:
    """Text (None if empty), tint, side of zero and note of each cell, and whether it is framed."""
    largest = float(np.nanmax(np.abs(heat.values), initial=0.0)) or 1.0
    return [
        [
            {
                "text": None if np.isnan(value) else _number(value, heat.digits),
                "tint": None if np.isnan(value) else f"{abs(value) / largest * 50:.0f}%",
                "side": "minus" if heat.diverging and value < 0.0 else "plus",
                "note": heat.notes[i][j] if heat.notes else None,
                "framed": (i, j) in heat.framed,
            }
            for j, value in enumerate(values)
        ]
        for i, values in enumerate(heat.values.tolist())
    ]


def _bars(bars: Bars) -> tuple[list[list[dict[str, str]]], str]:
    """Width, role and text of the bars of each label; and where the mark is, "" if there is none."""
    numbers = [v for g in bars.groups for v in g.values.tolist() if np.isfinite(v)]
    whole = bars.full or max([*numbers, bars.mark or 0.0]) or 1.0

    def bar(value: float, role: str) -> dict[str, str]:
        width = min(max(value, 0.0) / whole, 1.0) * 100 if np.isfinite(value) else 0.0
        return {"width": f"{width:.2f}%", "role": role, "text": _number(value, bars.digits)}

    rows = [[bar(float(g.values[i]), g.role) for g in bars.groups] for i in range(len(bars.labels))]
    return rows, "" if bars.mark is None else f"{bars.mark / whole * 100:.2f}%"


def _intervals(found: Intervals) -> tuple[list[dict[str, str] | None], str, str]:
    """Place of dot and bar for each label, None if there is no value; place of the null value, and of the common one.

    A bar without an end is as wide as the figure.
    """
    there = np.isfinite(found.values)
    error = np.where(np.isfinite(found.errors), found.errors, 0.0)
    common = [] if found.common is None else [found.common]
    ends = np.concatenate([(found.values - error)[there], (found.values + error)[there], common, [found.null]])
    low, high = float(ends.min()), float(ends.max())
    margin = 0.06 * (high - low or 1.0)
    low, high = low - margin, high + margin

    def part(length: float) -> str:
        return f"{min(max(length / (high - low), 0.0), 1.0) * 100:.2f}%"

    def place(value: float) -> str:
        return part(value - low)

    rows = [
        {"dot": place(v), "begin": place(v - e), "width": part(2.0 * e)} if np.isfinite(v) else None
        for v, e in zip(found.values.tolist(), found.errors.tolist(), strict=True)
    ]
    return rows, place(found.null), "" if found.common is None else place(found.common)


def _number(value: float, digits: str) -> str:
    return format(value, digits).rstrip(".").replace("-", "−") if np.isfinite(value) else "–"
