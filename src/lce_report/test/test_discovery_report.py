# SPDX-License-Identifier: Apache-2.0
"""The report of a discovery: a heater that loses more heat than the base model knows."""

import re

import numpy as np
import pytest

from lce_analysis import discover
from lce_analysis.discovery import Discovery
from lce_data.run import Run, Series
from lce_model import default_model, simulate
from lce_report import Grid, Lines, Section
from lce_report.figures.closures import formula_over_curve, found_function, overview
from lce_report.pages.discovery import discovery_sections, render_discovery

HEATER = default_model("lumped", "none").set({"lumped.gain": 45.0, "lumped.tau": 12.0, "ambient.t_env": 297.0})
TIME_S = np.arange(0.0, 80.0, 0.05)
POWERS = {
    "pulse": np.where((TIME_S > 2.0) & (TIME_S < 30.0), 1.3, 0.0),
    "stairs": 0.3 * (TIME_S // 14.0) % 1.5,
    "steps": np.where(np.sin(0.41 * TIME_S) + np.sin(0.97 * TIME_S) > 0.2, 1.4, 0.1),
    "holds": np.select([TIME_S < 25.0, TIME_S < 50.0], [1.2, 0.4], 0.9),
}


def run(name: str, seed: int) -> Run:
    """A run of the heater that also loses heat as the fourth power of its temperature."""
    made = simulate(
        HEATER.add("radiation").set({"radiation.emissivity": 0.9, "radiation.area_per_capacity": 8e-3}),
        TIME_S,
        POWERS[name],
    )
    noise = 0.05 * np.random.default_rng(seed).standard_normal(TIME_S.size)
    seen = Series(TIME_S[::2], (made.temperature_k + noise)[::2])
    return Run.of(name, Series(TIME_S, POWERS[name]), seen, sha256=name)


TRAIN, TEST = [run("pulse", 1), run("stairs", 2), run("steps", 3)], [run("holds", 4)]


@pytest.fixture(scope="module")
def found() -> Discovery:
    return discover(HEATER, TRAIN, TEST)


def test_the_page_says_what_the_command_prints_and_asks_for_nothing(found: Discovery) -> None:
    page = render_discovery(found, TRAIN, TEST)
    for sentence in found.sentences:
        assert sentence.replace("&", "&amp;").replace("<", "&lt;").replace("'", "&#39;") in page
    headings = re.findall(r"<h2>([^<]*)</h2>", page)
    told = ["What the residual shows", "What was found", "The formulas", "The errors", "What was tried"]
    assert headings[: len(told)] == told
    assert {"Predictive check", "pulse", "holds (held out)"} <= set(headings)
    assert not re.search(r"(src|href)\s*=\s*[\"']?(https?:)?//", page)
    assert "/tmp" not in page


def test_the_curve_is_drawn_within_the_data_with_each_formula_on_it(found: Discovery) -> None:
    (one,) = found.found
    (figure, _) = [figure for block in found_function(one) if isinstance(block, Grid) for figure in block.figures]
    assert isinstance(figure, Lines)
    assert figure.x_axis.unit == "°C" and figure.y_axis.unit == "K/s"
    hottest_c = max(float(run.temperature.value.max()) for run in TRAIN if run.temperature is not None) - 273.15
    assert figure.x[0] > 20.0 and figure.x[-1] < hottest_c + 0.5
    curve, *formulas = figure.curves
    assert curve.low is not None and curve.high is not None
    assert np.all(curve.low <= curve.y) and np.all(curve.y <= curve.high)
    assert [formula.label for formula in formulas] == [formula.expression for formula in one.formulas]
    at_knots = formula_over_curve(one.formulas[0], one, one.curve.x)
    assert np.max(np.abs(at_knots - one.curve.y)) < 0.1 * np.ptp(one.curve.y)


def test_the_overview_frames_what_was_found(found: Discovery) -> None:
    (table,) = [overview(examination, found.found) for examination in found.examinations]
    ((row, column),) = table.framed
    assert (table.rows[row], table.columns[column]) == ("temperature", "heat")
    assert 0.8 < table.values[row, column] <= 1.0
    assert table.notes[row][column].startswith("ln evidence")


def test_a_discovery_of_nothing_has_no_empty_sections() -> None:
    bare = [Run.of(r.name, r.power, r.temperature, sha256=r.name) for r in TRAIN]
    model = HEATER.add("radiation").set({"radiation.emissivity": 0.9, "radiation.area_per_capacity": 8e-3})
    sections = discovery_sections(discover(model, bare, TEST))
    assert all(isinstance(section, Section) and section.blocks for section in sections)
    assert "What was found" not in [section.heading for section in sections]
