# SPDX-License-Identifier: Apache-2.0
"""What a page is made of, as plain values: sections of prose, tables and figures.

All arrays are (n,) in the units of the axes that they are drawn on. A figure says what is shown, never how: colours
follow from roles, in light and dark, and the page thins what the eye cannot see.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Role = Literal["measured", "model", "residual", "input", "heating", "cooling", "before", "after", "quiet"]
Form = Literal["line", "step", "dashed", "points", "marked"]
"""marked is a line with its points."""
NUMBER: Final = re.compile(r"\(?[−+-]?[.\d]")
"""How a cell begins that is aligned to the right."""


@dataclass(frozen=True)
class Axis:
    """What an axis shows, and its unit ("1" for a pure number).

    whole : its ticks are whole numbers.
    from_zero : the y axis of Lines begins at zero, so that heights can be compared.
    log : an axis of Lines is logarithmic; all numbers are positive.
    """

    name: str
    unit: str
    whole: bool = False
    from_zero: bool = False
    log: bool = False


@dataclass(frozen=True)
class Curve:
    """A curve over the x of its figure; low and high bound a shaded band, NaN is a gap."""

    label: str
    y: Floats
    role: Role
    form: Form = "line"
    low: Floats | None = None
    high: Floats | None = None


@dataclass(frozen=True)
class Lines:
    """Curves over one increasing x. Figures that are ``linked`` by the same name zoom and point together in x.

    ``marks`` are labelled lines across, at values of x.
    """

    title: str
    x_axis: Axis
    y_axis: Axis
    x: Floats
    curves: Sequence[Curve]
    linked: str = ""
    height: int = 170
    marks: Sequence[tuple[float, str]] = ()


@dataclass(frozen=True)
class Trace:
    """Points anywhere in the plane, in their order; ``at`` is where each is on the linked x axis (its time)."""

    label: str
    x: Floats
    y: Floats
    role: Role
    form: Form = "points"
    at: Floats | None = None


@dataclass(frozen=True)
class Loop:
    """Traces in the plane: hysteresis loops, clouds of points. Linked, it shows what the linked figures zoom to."""

    title: str
    x_axis: Axis
    y_axis: Axis
    traces: Sequence[Trace]
    linked: str = ""
    height: int = 240


@dataclass(frozen=True)
class Heat:
    """A table of numbers (rows, columns) tinted by size, NaN left empty; diverging: negative and positive apart.

    digits is the format of a number; notes, of the same shape, appear under the pointer. Cells (row, column) of
    ``framed`` have a frame. In the workbench a cell is a button, and ``pick`` is the name that its click reports.
    """

    title: str
    corner: str
    columns: Sequence[str]
    rows: Sequence[str]
    values: Floats
    digits: str = ".0%"
    diverging: bool = False
    notes: Sequence[Sequence[str]] = ()
    pick: str = ""
    framed: Sequence[tuple[int, int]] = ()


@dataclass(frozen=True)
class Group:
    """One bar for each label of a bar chart."""

    label: str
    role: Role
    values: Floats


@dataclass(frozen=True)
class Bars:
    """Horizontal bars from zero, one group under the other; unit "1" is a pure number.

    ``mark`` is a threshold; ``full`` is the value of a whole bar, else the largest there is.
    """

    title: str
    unit: str
    labels: Sequence[str]
    groups: Sequence[Group]
    digits: str = "#.3g"
    mark: float | None = None
    full: float | None = None


@dataclass(frozen=True)
class Table:
    """Text in cells; the columns where a cell begins like a number are aligned to the right."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]

    @property
    def numeric(self) -> list[bool]:
        """Which columns are aligned to the right."""
        return [any(NUMBER.match(row[i]) for row in self.rows) for i in range(len(self.head))]


@dataclass(frozen=True)
class Intervals:
    """Values with their standard errors, a dot on its bar for each label, NaN left out.

    texts are the same in words. ``null`` is drawn as a line, and so is ``common``, dashed: a value for all labels.
    """

    title: str
    unit: str
    labels: Sequence[str]
    values: Floats
    errors: Floats
    texts: Sequence[str]
    null: float
    common: float | None = None


Figure = Lines | Loop | Heat | Bars | Intervals | Table


@dataclass(frozen=True)
class Grid:
    """Figures side by side, row by row, in columns of these relative widths; a tuple stacks its figures in one cell."""

    figures: Sequence[Figure | tuple[Figure, ...]]
    widths: Sequence[int] = (1, 1, 1)


@dataclass(frozen=True)
class Details:
    """Tables and paragraphs that a click on the summary opens."""

    summary: str
    blocks: Sequence[str | Table]


Block = str | Figure | Grid | Details


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it; a string is a paragraph."""

    heading: str
    blocks: Sequence[Block]
