# SPDX-License-Identifier: Apache-2.0
"""What static/figures.js draws, as the JSON that it reads."""

from typing import NotRequired, TypedDict

from lce_report.blocks import Form, Role

Numbers = tuple[int, int, float, float] | tuple[int, int]
"""Where an array is among the numbers of the page, as Arrays or Samples of :mod:`lce_report.html.arrays` keep it."""


class CurveDescription(TypedDict):
    """A curve over the x of its figure."""

    label: str
    role: Role
    form: Form
    y: Numbers
    low: NotRequired[Numbers]
    high: NotRequired[Numbers]


class TraceDescription(TypedDict):
    """Points in the plane."""

    label: str
    role: Role
    form: Form
    x: Numbers
    y: Numbers
    at: NotRequired[Numbers]


class FigureDescription(TypedDict):
    """What every figure has; an axis has the fields of :class:`lce_report.blocks.Axis`."""

    title: str
    xAxis: dict[str, str | bool]
    yAxis: dict[str, str | bool]
    linked: str
    height: int


class LinesDescription(FigureDescription):
    """Curves over one x."""

    x: Numbers
    curves: list[CurveDescription]
    marks: list[tuple[float, str]]


class LoopDescription(FigureDescription):
    """Traces in the plane."""

    traces: list[TraceDescription]
