# SPDX-License-Identifier: Apache-2.0
"""Answers as one HTML file that opens anywhere, without a network: sections of plain values, and their page."""

from lce_report.arrays import Samples
from lce_report.blocks import Axis, Bars, Block, Curve, Figure, Grid, Group, Heat, Lines, Loop, Section, Table, Trace
from lce_report.change import falls
from lce_report.comparison_page import provenance, render_comparison
from lce_report.page import Fragment, render

__all__ = [
    "Axis",
    "Bars",
    "Block",
    "Curve",
    "Figure",
    "Fragment",
    "Grid",
    "Group",
    "Heat",
    "Lines",
    "Loop",
    "Samples",
    "Section",
    "Table",
    "Trace",
    "falls",
    "provenance",
    "render",
    "render_comparison",
]
