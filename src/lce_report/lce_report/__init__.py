# SPDX-License-Identifier: Apache-2.0
"""Answers as one HTML file that opens anywhere, without a network.

``blocks``
    what a page is made of, as plain values: paragraphs, tables and figures.
``figures/``
    blocks from results of the analysis, one file a subject: a new plot of a report goes here.
``tables``
    the tables of a diagnosis, which the command prints too.
``pages/``
    the reports, one file each: `lce compare`, `diagnose`, `discover`, `add`, `tune` and `control`.
``paper``
    the curves of a page as SVG and PDF.
``html/``, ``templates/``, ``static/``
    how blocks become HTML, and what draws them.

Only ``blocks`` and ``html`` are loaded with the package; the others load the analysis.

Examples
--------
>>> import numpy as np
>>> from lce_report import Axis, Curve, Lines, Section, render
>>> time_s = np.linspace(0.0, 10.0, 101)
>>> d = Curve("measured", 0.1 * time_s, "measured")
>>> figure = Lines("displacement", Axis("time", "s"), Axis("d", "mm"), time_s, (d,))
>>> page = render("A title", ("The answer.",), (Section("Evidence", ("A paragraph.", figure)),))
>>> page.splitlines()[0]
'<!doctype html>'
"""

from lce_report.blocks import (
    Axis,
    Bars,
    Block,
    Curve,
    Details,
    Figure,
    Grid,
    Group,
    Heat,
    Intervals,
    Lines,
    Loop,
    Section,
    Table,
    Trace,
)
from lce_report.html.arrays import Samples
from lce_report.html.fragment import Fragment
from lce_report.html.render import render

__all__ = [
    "Axis",
    "Bars",
    "Block",
    "Curve",
    "Details",
    "Figure",
    "Fragment",
    "Grid",
    "Group",
    "Heat",
    "Intervals",
    "Lines",
    "Loop",
    "Samples",
    "Section",
    "Table",
    "Trace",
    "render",
]
