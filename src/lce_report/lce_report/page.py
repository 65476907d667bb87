# SPDX-License-Identifier: Apache-2.0
"""From sections to the text of one HTML file that opens anywhere, without a network."""

import html
import json
import re
from collections.abc import Sequence
from importlib.resources import files
from string import Template
from typing import Any, Final

import numpy as np

from lce_report.arrays import Arrays, Samples, distinct, visible
from lce_report.blocks import Bars, Block, Grid, Heat, Lines, Loop, Section, Table

NUMBER: Final = re.compile(r"[−+-]?[.\d]")


def render(title: str, answer: Sequence[str], sections: Sequence[Section], footer: Sequence[str] = ()) -> str:
    """The self-contained page: the answer in sentences, then the evidence, then where it came from."""
    here, uplot = files("lce_report"), files("uplot") / "static"
    arrays = Arrays()
    page = Fragment(arrays)
    body = "".join(
        f'<section id="s{i}"><h2>{_text(s.heading)}</h2>{"".join(page.block(b) for b in s.blocks)}</section>\n'
        for i, s in enumerate(sections)
    )
    return Template((here / "page.html").read_text(encoding="utf-8")).substitute(
        title=_text(title),
        answer="".join(f"<p>{_text(s)}</p>" for s in answer),
        contents=" ".join(f'<a href="#s{i}">{_text(s.heading)}</a>' for i, s in enumerate(sections)),
        sections=body,
        footer="".join(f"<p>{_text(line)}</p>" for line in footer),
        style="".join(
            file.read_text(encoding="utf-8")
            for file in (uplot / "uPlot.min.css", here / "figures.css", here / "page.css")
        ),
        figures=json.dumps(page.figures, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c"),
        numbers=arrays.packed(),
        uplot=(uplot / "uPlot.iife.js").read_text(encoding="utf-8").replace("</script", "<\\/script"),
        script="".join((here / name).read_text(encoding="utf-8") for name in ("figures.js", "page.js")),
    )


class Fragment:
    """HTML of blocks; what the script draws gathers in ``figures`` and ``arrays``.

    With Samples, curves keep every sample, and the cells of a table that has something to pick are buttons.
    """

    def __init__(self, arrays: Arrays | Samples) -> None:
        self.figures: list[dict[str, Any]] = []
        self.arrays = arrays
        self._answers = isinstance(arrays, Samples)

    def block(self, block: Block) -> str:
        """The HTML of one block."""
        match block:
            case str():
                return f"<p>{_text(block)}</p>"
            case Grid():
                columns = " ".join(f"minmax(0, {w}fr)" for w in block.widths)
                many = " many" if len(block.widths) > 2 else ""
                return f'<div class="grid{many}" style="grid-template-columns: {columns}">{self._cells(block)}</div>'
            case Lines() | Loop():
                spec = self._lines(block) if isinstance(block, Lines) else self._loop(block)
                self.figures.append(
                    {
                        "title": block.title,
                        "xAxis": vars(block.x_axis),
                        "yAxis": vars(block.y_axis),
                        "linked": block.linked,
                        "height": block.height,
                        **spec,
                    }
                )
                caption = f"<figcaption>{_text(block.title)}<output></output></figcaption>"
                return f'<figure data-figure="{len(self.figures) - 1}">{caption}</figure>'
            case Heat():
                return _heat(block, block.pick if self._answers else "")
            case Bars():
                return _bars(block)
            case Table():
                return _table(block)

    def _cells(self, grid: Grid) -> str:
        stacks = [f if isinstance(f, tuple) else (f,) for f in grid.figures]
        return "".join(f"<div>{''.join(self.block(figure) for figure in stack)}</div>" for stack in stacks)

    def _lines(self, figure: Lines) -> dict[str, Any]:
        edges = [e for c in figure.curves for e in (c.y, c.low, c.high) if e is not None]
        keep = np.arange(figure.x.size) if self._answers else visible(edges)
        return {
            "x": self.arrays.add(figure.x[keep]),
            "curves": [
                {"label": c.label, "role": c.role, "form": c.form, "y": self.arrays.add(c.y[keep])}
                | {
                    name: self.arrays.add(edge[keep])
                    for name, edge in (("low", c.low), ("high", c.high))
                    if edge is not None
                }
                for c in figure.curves
            ],
        }

    def _loop(self, figure: Loop) -> dict[str, Any]:
        traces = []
        for t in figure.traces:
            keep = distinct(t.x, t.y, joined=t.form != "points")
            spec = {"x": self.arrays.add(t.x[keep]), "y": self.arrays.add(t.y[keep])}
            if t.at is not None:
                spec["at"] = self.arrays.add(t.at[keep])
            traces.append({"label": t.label, "role": t.role, "form": t.form} | spec)
        return {"traces": traces}


def _text(text: str) -> str:
    return html.escape(text)


def _table(table: Table) -> str:
    numeric = [any(NUMBER.match(row[i]) for row in table.rows) for i in range(len(table.head))]
    head = "".join(_cell("th", 'scope="col"', text, n) for text, n in zip(table.head, numeric, strict=True))
    rows = "".join(
        "<tr>"
        + _cell("th", 'scope="row"', row[0], False)
        + "".join(_cell("td", "", text, n) for text, n in zip(row[1:], numeric[1:], strict=True))
        + "</tr>"
        for row in table.rows
    )
    return f"<table>{_caption(table.title)}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _cell(tag: str, scope: str, text: str, number: bool) -> str:
    """A cell of a column of numbers stands to the right."""
    return f"<{tag} {scope}{' class=n' if number else ''}>{_text(text)}</{tag}>"


def _caption(title: str) -> str:
    return f"<caption>{_text(title)}</caption>" if title else ""


def _heat(heat: Heat, pick: str) -> str:
    """The tint of a cell is its part of the largest number in the table; with ``pick``, it is a button."""
    largest = float(np.nanmax(np.abs(heat.values), initial=0.0)) or 1.0
    corner = f'<th scope="col">{_text(heat.corner)}</th>' if heat.corner else "<td></td>"
    head = corner + "".join(f'<th scope="col">{_text(c)}</th>' for c in heat.columns)
    rows = []
    for i, (name, values) in enumerate(zip(heat.rows, heat.values.tolist(), strict=True)):
        cells = []
        for j, value in enumerate(values):
            note = f' title="{_text(heat.notes[i][j])}"' if heat.notes else ""
            if np.isnan(value):
                cells.append(f"<td{note}></td>")
                continue
            side = "minus" if heat.diverging and value < 0.0 else "plus"
            tint = f"--tint:{abs(value) / largest * 50:.0f}%"
            text = _number(value, heat.digits)
            if pick:
                told = _text(f"{name}, {heat.columns[j]}: {text}")
                of = f'data-pick="{_text(pick)}" data-row="{i}" data-column="{j}"'
                text = f'<button type="button" {of} aria-pressed="false" aria-label="{told}">{text}</button>'
            cells.append(f'<td class="n {side}" style="{tint}"{note}>{text}</td>')
        rows.append(f'<tr><th scope="row">{_text(name)}</th>{"".join(cells)}</tr>')
    return (
        f'<table class="heat">{_caption(heat.title)}<thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _bars(bars: Bars) -> str:
    """One row for each label: its bars, and their numbers."""
    numbers = [v for g in bars.groups for v in g.values.tolist() if np.isfinite(v)]
    whole = bars.full or max([*numbers, bars.mark or 0.0]) or 1.0
    mark = "" if bars.mark is None else f'<i class="mark" style="left:{bars.mark / whole * 100:.2f}%"></i>'
    keys = "".join(
        f'<th scope="col"><i class="key" style="background:var(--{g.role})"></i>{_text(g.label)}</th>'
        for g in bars.groups
    )
    rows = []
    for i, label in enumerate(bars.labels):
        values = [float(g.values[i]) for g in bars.groups]
        widths = [min(max(v, 0.0) / whole, 1.0) * 100 if np.isfinite(v) else 0.0 for v in values]
        drawn = "".join(
            f'<b style="width:{w:.2f}%;background:var(--{g.role})"></b>'
            for w, g in zip(widths, bars.groups, strict=True)
        )
        cells = "".join(f"<td class=n>{_number(v, bars.digits)}</td>" for v in values)
        rows.append(
            f'<tr><th scope="row">{_text(label)}</th><td class="bar"><span>{drawn}{mark}</span></td>{cells}</tr>'
        )
    unit = "" if bars.unit == "1" else f" [{bars.unit}]"
    return (
        f'<table class="bars">{_caption(bars.title + unit)}<thead><tr><td></td><td></td>{keys}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def _number(value: float, digits: str) -> str:
    return format(value, digits).replace("-", "−") if np.isfinite(value) else "–"
