# SPDX-License-Identifier: Apache-2.0
"""`lce compare` from a CSV to the table, the JSON and the report."""

import json
from pathlib import Path

import numpy as np
import pytest

from lce_app.cli.main import main as lce
from lce_data.units import KELVIN
from lce_model import default_model, save_model, simulate


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A recording of the published strip, 30 s, camera at 10 Hz and distance at 100 Hz."""
    rng = np.random.default_rng(0)
    time = np.arange(0.0, 30.0, 0.01)
    power = np.where((time > 1.0) & (time < 12.0), 1.2, 0.0)
    made = simulate(default_model(), time, power)
    temperature = made.temperature_k - KELVIN + 0.06 * rng.standard_normal(time.size)
    displacement = made.displacement_m + 4e-6 * rng.standard_normal(time.size)
    rows = [
        f"{t:.2f},{p:.3f},{f'{k:.3f}' if i % 10 == 0 else ''},{d:.8f}"
        for i, (t, p, k, d) in enumerate(zip(time, power, temperature, displacement, strict=True))
    ]
    path = tmp_path / "a_run_with_a_rather_long_name.csv"
    path.write_text("\n".join(["time_s,power_w,temperature_c,displacement_m", *rows]) + "\n")
    return path


def test_table_json_and_report(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, report, numbers = tmp_path / "m.yaml", tmp_path / "r.html", tmp_path / "r.json"
    save_model(default_model().set({"lumped.tau": 1.1 * default_model()["lumped.tau"]}), model)
    assert lce(["compare", str(run), "--model", str(model), "--json", str(numbers), "--report", str(report)]) == 0
    out = capsys.readouterr().out
    content = json.loads(numbers.read_text())
    head, *rows = out.splitlines()[:3]
    assert "NRMSE" in head and {len(row) for row in rows} == {len(head)}  # in columns, whatever the name
    assert f"{content['runs'][0]['temperature']['nrmse']:.2%}" in rows[0]
    assert f"{content['runs'][0]['displacement']['rms_over_noise']:.2f}" in rows[1]
    assert content["sentences"][0] in out and str(report) in out
    assert "squared error of" in content["sentences"][0]
    assert content["sentences"][0] in report.read_text(encoding="utf-8")


def test_the_predictive_check_is_told_and_shown(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, report, numbers = tmp_path / "m.yaml", tmp_path / "r.html", tmp_path / "r.json"
    save_model(default_model(), model)
    asked = ["compare", str(run), "--model", str(model), "--json", str(numbers)]
    assert lce([*asked, "--predictive-check", "40", "--report", str(report)]) == 0
    out, content = capsys.readouterr().out, json.loads(numbers.read_text())["predictive_check"]
    assert content["draws"] == 40
    assert content["temperature"]["as_expected"] and content["displacement"]["as_expected"]
    assert all(sentence in out and sentence in report.read_text() for sentence in content["sentences"])
    assert "Predictive check" in report.read_text()
    assert lce(asked) == 0
    assert json.loads(numbers.read_text())["predictive_check"] is None
    assert lce([*asked, "--predictive-check", "3"]) == 1
    assert "3 simulations are too few" in capsys.readouterr().err


def test_what_cannot_be_compared_is_one_line_and_writes_nothing(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, report = tmp_path / "m.yaml", tmp_path / "r.html"
    save_model(default_model(), model)
    run.write_text(run.read_text().replace("displacement_m", "displacement_mm", 1))
    assert lce(["compare", str(run), "--model", str(model), "--report", str(report)]) == 1
    error = capsys.readouterr().err
    assert error.startswith("lce: ") and error.count("\n") == 1 and "displacement_mm" in error
    assert not report.exists()


def test_the_measured_temperature_may_drive(run: Path, tmp_path: Path) -> None:
    model, numbers = tmp_path / "m.yaml", tmp_path / "r.json"
    save_model(default_model().set({"lumped.tau": 1.1 * default_model()["lumped.tau"]}), model)
    over_noise = {}
    for drive in ("model", "measured"):
        assert lce(["compare", str(run), "--model", str(model), "--json", str(numbers), "--drive", drive]) == 0
        over_noise[drive] = json.loads(numbers.read_text())["runs"][0]["displacement"]["rms_over_noise"]
    assert over_noise["measured"] < 0.6 * over_noise["model"]  # the error was in the thermal stage alone
