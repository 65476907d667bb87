# SPDX-License-Identifier: Apache-2.0
"""Figures as SVG and PDF."""

from dataclasses import replace

import numpy as np
import pytest

from lce_report import Axis, Curve, Grid, Lines, Loop, Table, Trace
from lce_report.paper import Format, curves_of, draw, written

TIME_S = np.linspace(0.0, 10.0, 101)
BAND = Curve("residual", np.sin(TIME_S), "residual", low=-np.ones(101), high=np.ones(101))
LINES = Lines("residual d", Axis("time", "s"), Axis("d", "µm"), TIME_S, (BAND, Curve("zero", 0.0 * TIME_S, "quiet")))
LOOP = Loop("loop", Axis("T", "°C"), Axis("d", "mm"), (Trace("measured", TIME_S, TIME_S, "measured"),))


def test_a_figure_has_its_units_its_legend_and_the_part_that_was_in_view() -> None:
    figure = draw(LINES, (2.0, 4.0))
    (axes,) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == ("time [s]", "d [µm]", "residual d")
    assert axes.get_xlim() == (2.0, 4.0)
    legend = axes.get_legend()
    assert legend is not None and [text.get_text() for text in legend.get_texts()] == ["residual", "zero"]
    assert draw(LOOP).axes[0].get_legend() is None


def test_a_mark_is_a_labelled_line_whatever_its_text() -> None:
    block = replace(LINES, marks=((1.0, r"5 $ and \frac{$ <b>"), (1e9, "out of view")))
    assert "and \\frac{" in written(block, "svg", (0.0, 2.0)).decode()
    (axes,) = draw(block, (0.0, 2.0)).axes
    assert [1.0, 1.0] in [list(line.get_xdata()) for line in axes.lines] and axes.get_xlim() == (0.0, 2.0)
    assert draw(block).axes[0].get_xlim()[1] < 20.0, "a mark beyond the data"


def test_an_axis_that_begins_at_zero_does_so_on_paper() -> None:
    axis = Axis("RMS error, × noise", "1", from_zero=True)
    (axes,) = draw(Lines("errors", Axis("model", "1"), axis, TIME_S, (Curve("d", TIME_S + 5.0, "model"),))).axes
    assert axes.get_ylim()[0] == 0.0 and axes.get_ylabel() == "RMS error, × noise"


@pytest.mark.parametrize(("kind", "begins"), [("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_the_same_data_give_the_same_file(kind: Format, begins: bytes) -> None:
    file = written(LINES, kind)
    assert file.startswith(begins) and file == written(LINES, kind)
    assert kind != "svg" or "d [µm]" in file.decode()  # text stays text


def test_figures_are_counted_as_the_page_counts_them() -> None:
    table = Table("a table", ("a",), (("1",),))
    assert curves_of(["text", Grid(((LINES, table), LOOP)), table, LOOP]) == [LINES, LOOP, LOOP]
