# SPDX-License-Identifier: Apache-2.0
"""A small diagnosis as the command prints it, as the report shows it, and as the page does: the same numbers."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from lce_analysis.comparison.compare import compare
from lce_analysis.diagnosis import Addition, Diagnosis, add_effect, diagnose
from lce_analysis.diagnosis.diagnosis import ErrorTable
from lce_analysis.diagnosis.linearized_fit import spans
from lce_analysis.options import CompareOptions
from lce_app.cli.commands import diagnose as command
from lce_app.workbench import drawings
from lce_app.workbench.records import DiagnosisRecord, diagnosis_record, read_diagnosis
from lce_data.channels import DISPLACEMENT
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate
from lce_model.effects import find
from lce_report import Intervals, Table
from lce_report.figures.leading import _picture, strength_by_run, strength_intervals
from lce_report.pages.diagnosis import render_diagnosis
from lce_report.tables import MEANING, addition_tables, diagnosis_tables, estimate

BASE = default_model("lumped", "equilibrium")
STRIP = BASE.add("creep").set({"creep.share": 0.12, "creep.tau_v": 8.0})
CANDIDATES = [find(name) for name in ("creep", "displacement_drift", "ambient_drift")]
LEVELS_W = {"pulse": (2.3, 0.0, 0.0), "stairs": (1.0, 2.2, 1.2), "other": (2.4, 0.5, 2.0)}

pytestmark = pytest.mark.slow


def _run(name: str, strip: Model = STRIP) -> Run:
    """45 s of three levels of light, then darkness."""
    rng, time = np.random.default_rng(len(name)), np.arange(0.0, 45.0, 0.01)
    power = np.select([time < 9.0, time < 17.0, time < 25.0], LEVELS_W[name], 0.0)
    made = simulate(strip, time, power)
    seen_t = made.measured_temperature_k[::10] + 0.06 * rng.standard_normal(time[::10].size)
    seen_d = made.measured_displacement_m + 4e-6 * rng.standard_normal(time.size)
    return Run.of(name, Series(time, power), Series(time[::10], seen_t), Series(time, seen_d), sha256=name)


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    """Two to learn from, and one that is held out."""
    return [_run(name) for name in LEVELS_W]


@pytest.fixture(scope="module")
def found(runs: list[Run]) -> Diagnosis:
    return diagnose(BASE, runs[:2], runs[2:], CANDIDATES)


@pytest.fixture(scope="module")
def added(runs: list[Run]) -> Addition:
    return add_effect(BASE, "creep", runs[:2], runs[2:])


@pytest.fixture(scope="module")
def page(found: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> DiagnosisRecord:
    """What the workbench keeps of it, read again."""
    file = tmp_path_factory.mktemp("page") / "diagnosis-1.json"
    file.write_text(json.dumps(diagnosis_record(found)), encoding="utf-8")
    return read_diagnosis(file)


class _Tables(HTMLParser):
    """Rows of text of the tables of a page, by their captions."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.rows: dict[str, list[list[str]]] = {}
        self._title, self._at = "", ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._at = tag
        if tag == "caption":
            self._title = ""
        if tag == "tr":
            self.rows.setdefault(self._title, []).append([])
        if tag in ("th", "td") and self.rows:
            self.rows[self._title][-1].append("")

    def handle_data(self, data: str) -> None:
        if self._at == "caption":
            self._title += data
        elif self._at in ("th", "td"):
            self.rows[self._title][-1][-1] += data

    def handle_endtag(self, tag: str) -> None:
        self._at = ""


def _printed(table: Table, text: str) -> list[list[str]]:
    """The cells under a title in what a command prints."""
    lines = text.partition(f"{table.title}\n")[2].splitlines()[: 1 + len(table.rows)]
    return [re.split(r" {2,}", line.strip()) for line in lines]


def _told(table: Table, without: str = "") -> list[list[str]]:
    kept = [i for i, name in enumerate(table.head) if name != without]
    return [[row[i] for i in kept] for row in (table.head, *table.rows)]


def test_command_report_and_page_show_the_same_numbers(
    found: Diagnosis, runs: list[Run], page: DiagnosisRecord
) -> None:
    tables = diagnosis_tables(found)
    printed = command.summary(found, evidence=True)
    report = _Tables(render_diagnosis(found, runs[:2], runs[2:])).rows
    on_page = {block.title: block for block in drawings.diagnosis(page) if isinstance(block, Table)}
    assert tables.steps is not None and tables.ranking is not None and tables.strengths is not None
    for table in (tables.errors, tables.steps, tables.ranking):
        assert _printed(table, printed) == _told(table, without=MEANING)
        assert report[table.title] == _told(table)
        assert _told(on_page[table.title]) == _told(table)
    assert _printed(tables.strengths, printed) == _told(tables.strengths)
    assert report[tables.evidence.title] == _told(tables.evidence) == _told(page.tables.evidence)


def test_the_numbers_of_the_sentences_stand_in_the_tables(found: Diagnosis) -> None:
    tables = diagnosis_tables(found)
    assert tables.steps is not None
    cells = {cell for table in (tables.errors, tables.steps) for row in table.rows for cell in row}
    said = " ".join(found.sentences)
    changes, shares = re.findall(r"[\d.]+ → [\d.]+", said), re.findall(r"\d+%", said)
    assert "creep is missing" in said and changes and shares
    assert {*changes, *shares} <= cells
    assert set(re.findall(r"([\d.]+) × the noise", said)) <= cells


def test_the_columns_are_the_errors_of_three_models_that_can_be_simulated(found: Diagnosis, runs: list[Run]) -> None:
    models = {"as given": found.given, "refitted": found.before, "with creep": found.model}
    errors = diagnosis_tables(found).errors
    assert list(errors.head[2:5]) == list(models)
    for column, model in zip(errors.head[2:5], models.values(), strict=True):
        (held_out,) = compare(model, runs[2:], CompareOptions(drive=found.drive)).runs
        for channel, compared in held_out.channels.items():
            (row,) = [r for r in errors.rows if (r[0], r[1]) == ("held out: other", channel.symbol)]
            assert row[list(errors.head).index(column)] == f"{compared.metrics.over_noise:.2f}"


def test_a_picture_shows_the_residual_and_what_the_refit_takes_from_it(page: DiagnosisRecord) -> None:
    creep = page.leading[0]
    assert creep.effect == "creep" and creep.picture.sensor == "displacement"
    residual, change = (np.array(x, dtype=float) for x in (creep.picture.residual, creep.picture.change))
    assert np.nanstd(residual - change) < 1.1 * 4.0 < 0.5 * np.nanstd(residual)  # µm: nothing but the noise is left


def test_an_added_effect_has_its_errors_run_by_run(added: Addition, runs: list[Run]) -> None:
    models = {"as given": added.given, "refitted": added.before, "with creep": added.model}
    compared = {
        label: compare(model, runs, CompareOptions(drive=added.model.fit["drive"])) for label, model in models.items()
    }
    tables = addition_tables(added, compared, held_out={"other"})
    assert tables.errors.head == ("run", "sensor", "as given", "refitted", "with creep", "went")
    assert [row[:2] for row in tables.errors.rows][-2:] == [("other (held out)", "T"), ("other (held out)", "d")]
    sides: list[tuple[ErrorTable, int]] = [(added.train, 2), (added.test, 1)]
    wanted = [
        f"{np.sqrt(side.misfit['after'].total[c][i] / side.misfit['after'].samples[c][i]):.2f}"
        for side, count in sides
        for i in range(count)
        for c in side.misfit["after"].total
    ]
    assert [row[4] for row in tables.errors.rows] == wanted
    assert set(re.findall(r"→ ([\d.]+) × noise", added.sentence)) <= {row[4] for row in tables.errors.rows}
    dots = strength_intervals(strength_by_run("creep", added.amplitude, added.strength_by_run))
    assert isinstance(dots, Intervals) and list(dots.labels) == ["pulse", "stairs"]
    assert list(dots.texts) == [row[1] for row in tables.strengths.rows]
    assert dots.values == pytest.approx(0.12, abs=0.01)


@pytest.mark.parametrize(
    ("value", "error", "unit", "text"),
    [
        (0.12013, 0.00123, "1", "0.1201 ± 0.0012"),
        (301.1264, 0.0187, "K", "301.126 ± 0.019 K"),
        (-2.4, 21.7, "K", "−2 ± 22 K"),
        (1.06e-6, 6.2e-7, "m/s", "(1.06 ± 0.62)e-6 m/s"),
        (3.7e7, 4e5, "1", "(3.700 ± 0.040)e7"),
        (0.5, float("inf"), "s", "0.5 s"),
        (0.0, 0.0, "s", "0 s"),
    ],
)
def test_a_value_is_told_to_two_digits_of_its_error(value: float, error: float, unit: str, text: str) -> None:
    assert estimate(value, error, unit) == text


def test_an_adequate_model_says_what_it_leaves_of_the_runs_held_out(found: Diagnosis) -> None:
    adequate = replace(found, verdict="adequate", accepted=())
    assert any(
        re.match(r"Of other, held out, the model leaves \d\.\d\d × the noise", line) for line in adequate.sentences
    )
    worse = found.test.misfit["after"]
    worse = replace(worse, total={channel: 25.0 * x for channel, x in worse.total.items()})
    table = replace(found.test, misfit={**found.test.misfit, "after": worse})
    said = replace(adequate, test=table).sentences
    assert any(line.endswith(", more than of the runs learnt from.") for line in said)


def test_a_picture_is_of_one_series_whatever_sensors_the_two_fits_have(found: Diagnosis) -> None:
    """With the effect, the heat may not be bent any more; its fit has the temperature as well."""
    trial = found.steps[0].trial
    whole, fit = _picture(trial, found.runs), trial.stage.fit
    ends, observed = spans(fit.problem.observed), fit.problem.observed
    own = [i for i, series in enumerate(observed) if series.channel is DISPLACEMENT]
    problem = replace(fit.problem, observed=tuple(observed[i] for i in own))
    residual = np.concatenate([fit.residual[slice(*ends[i])] for i in own])
    before = replace(fit, problem=problem, residual=residual)
    part = _picture(replace(trial, stage=replace(trial.stage, fit=before)), found.runs)
    assert whole.sensor == "displacement" and part == whole
