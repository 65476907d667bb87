# SPDX-License-Identifier: Apache-2.0
"""Results as figures for a paper: every axis has its unit, every run and model its place."""

from io import BytesIO

import numpy as np
import pytest
from matplotlib.figure import Figure

import lce_analysis as lce
from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import simulate
from lce_report import plots

NOISE = {TEMPERATURE: 0.06, DISPLACEMENT: 4e-6}


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    """A strip with creep under two waveforms."""
    strip = lce.default_model("lumped", "equilibrium", ("creep",)).set({"creep.share": 0.2, "creep.tau_v": 10.0})
    rng, found = np.random.default_rng(0), []
    for name, power_w in {"pulse": [0.0, 1.5, 0.0], "stairs": [0.4, 1.0, 1.6]}.items():
        time_s = np.arange(0.0, 90.0, 0.1)
        power = np.repeat(power_w, 300)
        out = simulate(strip, time_s, power)
        temperature, displacement = (out[c] + NOISE[c] * rng.standard_normal(900) for c in NOISE)
        given = Series(time_s, power), Series(time_s, temperature), Series(time_s, displacement)
        found.append(Run.of(name, *given))
    return found


def saved(figure: Figure) -> bytes:
    """The figure as PDF."""
    file = BytesIO()
    figure.savefig(file, format="pdf")
    return file.getvalue()


def test_a_comparison_has_a_column_for_each_run(runs: list[Run]) -> None:
    model = lce.default_model("lumped", "equilibrium")
    figure = plots.comparison(lce.compare(model, runs))
    assert [axes.get_title() for axes in figure.axes if axes.get_title()] == ["pulse", "stairs"]
    labels = [axes.get_ylabel() for axes in figure.axes if axes.get_ylabel()]
    assert labels == ["P [W]", "T [°C]", "residual T [K]", "d [mm]", "residual d [µm]"]
    assert saved(figure).startswith(b"%PDF")


def test_a_comparison_without_displacement_has_no_panel_for_it(runs: list[Run]) -> None:
    model = lce.default_model("lumped", "none")
    figure = plots.comparison(lce.compare(model, runs[:1]))
    assert [axes.get_ylabel() for axes in figure.axes] == ["P [W]", "T [°C]", "residual T [K]"]


def test_a_row_holds_one_quantity_of_all_runs(runs: list[Run]) -> None:
    """Where a run lacks one, its place stays empty, and no other quantity takes it."""
    both = [runs[0].with_series(TEMPERATURE, None), runs[1]]
    figure = plots.comparison(lce.compare(lce.default_model("lumped", "equilibrium"), both))
    shown = [axes for axes in figure.axes if axes.axison]
    assert len(figure.axes) == 10 and len(shown) == 8
    first = {axes.get_subplotspec().rowspan.start for axes in shown if axes.get_subplotspec().colspan.start == 0}
    assert first == {0, 3, 4}


def test_a_diagnosis_shows_errors_and_strengths(runs: list[Run]) -> None:
    found = lce.diagnose(lce.default_model("lumped", "equilibrium"), runs)
    assert [step.added for step in found.steps] == ["creep"]
    figure = plots.diagnosis(found)
    errors, strength = figure.axes[0], figure.axes[1]
    assert [text.get_text() for text in errors.get_legend().get_texts()] == ["as given", "refitted", "with creep"]
    assert [label.get_text() for label in errors.get_xticklabels()] == ["T\ntraining", "d\ntraining"]
    heights = [bar.get_height() for bar in errors.patches]
    assert heights[5] == pytest.approx(found.train.misfit["after"].rms[DISPLACEMENT])
    assert strength.get_ylabel() == "creep.share"
    assert [label.get_text() for label in strength.get_xticklabels()] == ["pulse", "stairs"]
    assert saved(figure).startswith(b"%PDF")
