# SPDX-License-Identifier: Apache-2.0
"""`lce prepare`."""

from pathlib import Path

import numpy as np
import pytest

from lce_app.cli.main import main as lce
from lce_data.read_runs import read_run
from lce_data.run import Run, Series
from lce_data.run_csv import write_run_csv

TIME = np.arange(0.0, 20.0, 0.01)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two runs of the same name, and a recipe."""
    monkeypatch.chdir(tmp_path)
    light = Series(TIME, np.where((TIME > 2.0) & (TIME < 9.0), 1.0, 0.0))
    warm = Series(TIME[::10], 296.0 + np.clip(TIME[::10] - 2.0, 0.0, 7.0))
    for place in (tmp_path, tmp_path / "later"):
        place.mkdir(exist_ok=True)
        write_run_csv(place / "pulse.csv", *Run.of("pulse", power=light, temperature=warm).aligned())
    (tmp_path / "pulse.yaml").write_text("conditions: {strip_length_m: 0.01}\n")
    (tmp_path / "recipe.yaml").write_text(
        "format: lce-recipe-1\nsteps:\n"
        "- {step: detrend, channel: temperature, order: line, rest: [[0, 2]]}\n- {step: cut, begin_s: 12, end_s: 14}\n"
    )
    return tmp_path


def test_a_prepared_run_is_a_run_beside_its_recipe(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (folder / "pulse.csv").read_bytes()
    assert lce(["prepare", "pulse.csv", "--recipe", "recipe.yaml", "--out", "made"]) == 0
    out, err = capsys.readouterr()
    assert out == "made/pulse.csv\n"
    assert "lce: warning: pulse: a slow change of temperature that belongs to the strip goes with the line" in err
    run = read_run(folder / "made" / "pulse.csv")
    assert run.temperature is not None and not ((run.temperature.time_s >= 12) & (run.temperature.time_s <= 14)).any()
    assert run.strip_length_m == 0.01 and (folder / "pulse.csv").read_bytes() == before
    again = ["prepare", "pulse.csv", "--recipe", "made/pulse.recipe.yaml", "--out", "made", "--force"]
    first = (folder / "made" / "pulse.csv").read_bytes()
    assert lce(again) == 0 and (folder / "made" / "pulse.csv").read_bytes() == first


def test_a_model_of_the_name_of_a_prepared_run_is_not_overwritten(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = folder / "made" / "pulse.yaml"
    model.parent.mkdir()
    model.write_text("a model")
    assert lce(["prepare", "pulse.csv", "--recipe", "recipe.yaml", "--out", "made"]) == 1
    assert "pulse.yaml: exists already; --force overwrites it" in capsys.readouterr().err
    assert model.read_text() == "a model"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("pulse.csv later/pulse.csv --recipe recipe.yaml --out made", "several runs would be written as pulse.csv"),
        ("pulse.csv --recipe recipe.yaml --out .", "pulse.csv: exists already; --force overwrites it"),
        ("pulse.csv --recipe recipe.yaml --out . --force", "pulse.csv is the recording; a prepared run goes elsewhere"),
        ("pulse.csv --recipe none.yaml --out made", "none.yaml: No such file"),
        ("pulse.csv --recipe pulse.yaml --out made", "pulse.yaml: "),
        ("pulse.csv --recipe recipe.yaml --out pulse.yaml/made", "pulse.yaml/made: cannot be made"),
    ],
)
def test_what_cannot_be_prepared_is_one_line_and_nothing_is_written(
    folder: Path, capsys: pytest.CaptureFixture[str], words: str, why: str
) -> None:
    before = sorted(folder.rglob("*"))
    assert lce(["prepare", *words.split()]) == 1
    said = capsys.readouterr().err
    assert why in said and said.count("\n") == 1
    assert sorted(folder.rglob("*")) == before
