# SPDX-License-Identifier: Apache-2.0
"""HTML of blocks; what a script draws is described beside it as plain numbers."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lce_report.blocks import Bars, Block, Grid, Heat, Lines, Loop, Table
from lce_report.html.arrays import Arrays, Samples, distinct, visible
from lce_report.html.templates import templates

if TYPE_CHECKING:
    from markupsafe import Markup

NUMBER: Final = re.compile(r"[−+-]?[.\d]")
"""How a cell begins that is aligned to the right."""


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
        self.figures: list[dict[str, Any]] = []
        self.arrays = arrays
        self._answers = isinstance(arrays, Samples)
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
            case Table():
                numeric = [any(NUMBER.match(row[i]) for row in block.rows) for i in range(len(block.head))]
                html = self._html.table(block, numeric)
        return html

    def _figure(self, block: Lines | Loop) -> dict[str, Any]:
        return {
            "title": block.title,
            "xAxis": vars(block.x_axis),
            "yAxis": vars(block.y_axis),
            "linked": block.linked,
            "height": block.height,
            **(self._lines(block) if isinstance(block, Lines) else self._loop(block)),
        }

    def _lines(self, figure: Lines) -> dict[str, Any]:
        edges = [e for c in figure.curves for e in (c.y, c.low, c.high) if e is not None]
        keep = np.arange(figure.x.size) if self._answers else visible(edges)
        x, curves = self.arrays.add(figure.x[keep]), []
        for c in figure.curves:
            given = {
                name: values for name, values in (("y", c.y), ("low", c.low), ("high", c.high)) if values is not None
            }
            packed = {name: self.arrays.add(values[keep]) for name, values in given.items()}
            curves.append({"label": c.label, "role": c.role, "form": c.form} | packed)
        return {"x": x, "curves": curves}

    def _loop(self, figure: Loop) -> dict[str, Any]:
        traces = []
        for t in figure.traces:
            keep = distinct(t.x, t.y, joined=t.form != "points")
            given = {name: values for name, values in (("x", t.x), ("y", t.y), ("at", t.at)) if values is not None}
            packed = {name: self.arrays.add(values[keep]) for name, values in given.items()}
            traces.append({"label": t.label, "role": t.role, "form": t.form} | packed)
        return {"traces": traces}


def _heat_cells(heat: Heat) -> list[list[dict[str, str | None]]]:
    """Text (None if empty), tint, side of zero and note of each cell."""
    largest = float(np.nanmax(np.abs(heat.values), initial=0.0)) or 1.0
    return [
        [
            {
                "text": None if np.isnan(value) else _number(value, heat.digits),
                "tint": None if np.isnan(value) else f"{abs(value) / largest * 50:.0f}%",
                "side": "minus" if heat.diverging and value < 0.0 else "plus",
                "note": heat.notes[i][j] if heat.notes else None,
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


def _number(value: float, digits: str) -> str:
    return format(value, digits).replace("-", "−") if np.isfinite(value) else "–"
