# SPDX-License-Identifier: Apache-2.0
"""`lce import`: what was understood is shown, guesses are asked about, and nothing is written before."""

import logging
from pathlib import Path

import numpy as np
import pytest

from lce_app.cli import main as cli
from lce_app.use_cases.loading import load_runs
from lce_data.read_runs import read_run

TIME_S = np.arange(0.0, 60.0, 0.5)
POWER_W = np.where(TIME_S < 30.0, 1.0, 0.0)
WARM_C = 22.0 + 30.0 * np.where(TIME_S < 30.0, 1.0 - np.exp(-TIME_S / 8.0), np.exp(-(TIME_S - 30.0) / 8.0))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A table with a semicolon and decimal commas, of which only the time says its unit."""
    rows = [f"{1e3 * t};{100.0 * p};{k}" for t, p, k in zip(TIME_S, POWER_W, WARM_C, strict=True)]
    path = tmp_path / "day 1.csv"
    path.write_text("\n".join(["time_ms;Q1;T1", *rows]).replace(".", ","), encoding="utf-8-sig")
    return path


def lce_import(file: Path, *words: str) -> int:
    return cli.main(["import", str(file), "--out", str(file.parent / "runs"), *words])


def test_guesses_are_refused_where_nobody_can_be_asked(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert lce_import(file) == 1
    said = capsys.readouterr()
    assert "temperature?" in said.out and "°C?" in said.out
    assert (
        "guessed of Q1 (column and unit), T1 (column and unit); --column power=Q1:% --column temperature=T1:degC says "
        "the same, --yes takes every guess" in said.err
    )
    assert not (file.parent / "runs").exists()


def test_yes_takes_the_guesses_and_conditions_stand_beside_the_run(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    report = file.parent / "r.html"
    words = ["--yes", "--condition", "ambient_c=22", "--condition", "specimen=A7", "--report", str(report)]
    assert lce_import(file, *words) == 0
    said = capsys.readouterr()
    assert said.out.splitlines()[-2:] == [str(file.parent / "runs" / "day 1.csv"), str(report)]
    assert "Q1: 100 % counts as 1 W" in said.out
    run = read_run(file.parent / "runs" / "day 1.csv")
    assert run.power is not None and run.temperature is not None
    np.testing.assert_allclose(run.power.value, POWER_W)
    np.testing.assert_allclose(run.power.time_s, TIME_S)
    assert (run.experiment.conditions.ambient_c, run.experiment.conditions.specimen) == (22.0, "A7")
    assert "Q1" in report.read_text(encoding="utf-8")


def test_what_is_said_by_hand_is_no_guess(file: Path) -> None:
    assert lce_import(file, "--column", "power=Q1:mW", "--column", "temperature=3:degC") == 0
    run = read_run(file.parent / "runs" / "day 1.csv")
    assert run.power is not None and run.power.value.max() == pytest.approx(0.1)


def test_on_a_terminal_each_guess_is_asked_about(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answers = iter(["furlong", "mW", ""])
    asked: list[str] = []

    def answer(question: str) -> str:
        asked.append(question)
        return next(answers)

    monkeypatch.setattr("builtins.input", answer)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    assert lce_import(file) == 0
    assert asked == ["Q1 is the power in %? "] * 2 + ["T1 is the temperature in degC? "]
    run = read_run(file.parent / "runs" / "day 1.csv")
    assert run.power is not None and run.power.value.max() == pytest.approx(0.1)


def test_a_guess_that_cannot_be_is_asked_about_all_the_same(
    file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = file.read_text(encoding="utf-8-sig").replace("Q1", "reading (x)")
    file.write_text(text, encoding="utf-8")
    answers = iter(["K"])
    monkeypatch.setattr("builtins.input", lambda question: next(answers))
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    assert lce_import(file) == 1
    told = capsys.readouterr().err.splitlines()
    assert "no laser power" in told[0] and "no laser power" in told[-1]
    monkeypatch.setattr("sys.stdin.isatty", lambda: False)
    assert lce_import(file, "--column", "power=reading (x)") == 1
    assert "--column 'power=reading (x):%' --column temperature=T1:degC says the same" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--column", "warmth=T1"], "--column 'warmth=T1': expected QUANTITY=NAME[:UNIT] with one of time, power"),
        (["--condition", "warm"], "--condition warm: expected KEY=VALUE"),
        (["--condition", "load_n=heavy", "--yes"], "load_n is 'heavy'; it must be a number"),
        (["--column", "temperature=T1:%"], "'%' is not a unit that is known here; one of °C, K, °F"),
    ],
)
def test_what_cannot_be_used_is_told_in_one_line(
    words: list[str], told: str, file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert lce_import(file, *words) == 1
    assert told in capsys.readouterr().err
    assert not (file.parent / "runs").exists()


def test_nothing_is_written_where_the_report_cannot_be(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert lce_import(file, "--yes", "--report", str(file.parent / "none" / "r.html")) == 1
    assert "there is no folder" in capsys.readouterr().err
    assert not (file.parent / "runs").exists()


def test_two_files_of_one_name_are_refused(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = file.parent / "b"
    other.mkdir()
    (other / file.name).write_bytes(file.read_bytes())
    assert cli.main(["import", str(file), str(other / file.name), "--out", str(file.parent / "runs"), "--yes"]) == 1
    assert "several files are called day 1" in capsys.readouterr().err


def test_who_skips_the_import_is_warned_before_the_fit(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rows = [f"{t},{1e3 * p},{k}" for t, p, k in zip(TIME_S, POWER_W, WARM_C, strict=True)]
    (tmp_path / "x.csv").write_text("\n".join(["time_s,power_w,temperature_c", *rows]), encoding="utf-8")
    with caplog.at_level(logging.WARNING):
        load_runs([tmp_path / "x.csv"])
    (told,) = caplog.messages
    assert told.startswith("lce: warning: x: 1000 W warm by 30 K only; is the power in mW?")
