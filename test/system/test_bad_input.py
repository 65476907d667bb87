# SPDX-License-Identifier: Apache-2.0
"""What a user can get wrong: one clear line on stderr, exit 1, nothing written."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from run_command import lce

from lce_app.cli.main import main
from lce_data.units import KELVIN
from lce_model import Model, default_model, save_model, simulate

HEADER = "time_s,power_w,temperature_c,displacement_m"
STRIP = default_model()
Lines = list[str]


def _rows(strip: Model = STRIP) -> Lines:
    """A good CSV of 20 s at 10 Hz."""
    time = np.arange(0.0, 20.0, 0.1)
    power = np.where((time > 1.0) & (time < 10.0), 1.2, 0.0)
    made = simulate(strip, time, power)
    table = zip(time, power, made.temperature_k - KELVIN, made.displacement_m, strict=True)
    return [HEADER, *(f"{t:.2f},{p},{c:.3f},{d:.7f}" for t, p, c, d in table)]


def _cell(rows: Lines, line: int, column: int, text: str) -> Lines:
    cells = rows[line - 1].split(",")
    cells[column] = text
    return [*rows[: line - 1], ",".join(cells), *rows[line:]]


def _scaled(rows: Lines, column: int, change: Callable[[float], float]) -> Lines:
    for line in range(2, len(rows) + 1):
        value = float(rows[line - 1].split(",")[column])
        rows = _cell(rows, line, column, f"{change(value):.6f}")
    return rows


def _dark(rows: Lines) -> Lines:
    return _scaled(rows, 1, lambda _: 0.0)


CSV: dict[str, tuple[Callable[[Lines], Lines], str]] = {
    "no time column": (lambda r: [row.partition(",")[2] for row in r], "expected time_s"),
    "a column of another name": (lambda r: [HEADER.replace("power_w", "power_mw"), *r[1:]], "power_mw"),
    "neither temperature nor displacement": (lambda r: [",".join(x.split(",")[:2]) for x in r], "nothing to compare"),
    "nothing but a header": (lambda r: r[:1], "samples"),
    "an empty file": (lambda _: [], "expected time_s"),
    "NaN": (lambda r: _cell(r, 31, 2, "nan"), "row 31: temperature_c is nan"),
    "a word for a number": (lambda r: _cell(r, 31, 3, "far"), "row 31: displacement_m is 'far'"),
    "time backwards": (lambda r: _cell(r, 51, 0, "0.35"), "row 51: time does not increase"),
    "a time missing": (lambda r: _cell(r, 51, 0, ""), "row 51: time_s is empty"),
    "negative power": (lambda r: _cell(r, 21, 1, "-0.5"), "a laser gives 0 W or more"),
    "kelvin": (lambda r: _scaled(r, 2, lambda x: x + KELVIN), "is it in kelvin"),
    "millimetres": (lambda r: _scaled(r, 3, lambda x: 1000.0 * x), "is it in millimetres"),
    "a decimal comma": (lambda r: _cell(r, 31, 1, "1,2"), "row 31: 5 cells under a header of 4"),
}

MODEL: dict[str, tuple[Callable[[dict], None], str]] = {  # type: ignore[type-arg]
    "an unknown key": (lambda m: m.update(termal="lumped"), "unknown key 'termal'"),
    "an unknown parameter": (lambda m: m["parameters"]["lumped"].update(tua={"value": 1}), "unknown key 'tua'"),
    "an unknown model": (lambda m: m.update(deformation="equilibium"), "unknown model 'equilibium'"),
    "a unit that does not fit": (
        lambda m: m["parameters"]["lumped"]["tau"].update(unit="min"),
        "parameters.lumped.tau.unit: 'min'",
    ),
    "a value outside its range": (lambda m: m["parameters"]["lumped"]["tau"].update(value=-3.0), "lumped.tau: -3 s"),
    "a value that is no number": (
        lambda m: m["parameters"]["lumped"]["tau"].update(value="long"),
        "parameters.lumped.tau.value is 'long'",
    ),
}


@pytest.fixture
def refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Callable[[list[str], str], None]:
    """Run a command in ``tmp_path`` that must fail with one line that holds what is told, and leave nothing."""

    def check(words: list[str], told: str) -> None:
        monkeypatch.chdir(tmp_path)
        before = sorted(tmp_path.rglob("*"))
        assert main(words) == 1
        (line,) = capfd.readouterr().err.strip().splitlines()
        assert told in line
        assert sorted(tmp_path.rglob("*")) == before

    return check


@pytest.fixture(params=["fit", "compare", "diagnose"])
def command(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[..., list[str]]:
    """A command that reads runs, with all that it would write."""
    save_model(default_model(), tmp_path / "m.yaml")
    rest = {
        "fit": ["--out", "new.yaml"],
        "compare": ["--model", "m.yaml", "--report", "r.html", "--json", "r.json"],
        "diagnose": ["--model", "m.yaml", "--report", "r.html", "--json", "r.json"],
    }
    return lambda *runs: [request.param, *runs, *rest[request.param]]


@pytest.mark.parametrize("case", CSV)
def test_a_csv_that_is_wrong(
    case: str, tmp_path: Path, command: Callable[..., list[str]], refused: Callable[[list[str], str], None]
) -> None:
    change, told = CSV[case]
    (tmp_path / "good.csv").write_text("\n".join(_rows()) + "\n", encoding="utf-8")
    (tmp_path / "bad.csv").write_text("\n".join(change(_rows())) + "\n", encoding="utf-8")
    refused(command("good.csv", "bad.csv"), f"bad.csv, {told}" if told.startswith("row") else told)


@pytest.mark.parametrize("words", [["fit", "--out", "new.yaml"], ["diagnose", "--model", "m.yaml", "--json", "r.json"]])
def test_nothing_is_learnt_from_a_run_without_light(
    words: list[str], tmp_path: Path, refused: Callable[[list[str], str], None]
) -> None:
    save_model(default_model(), tmp_path / "m.yaml")
    (tmp_path / "dark.csv").write_text("\n".join(_dark(_rows())) + "\n", encoding="utf-8")
    refused([words[0], "dark.csv", *words[1:]], "dark: the laser power is 0 W throughout; nothing can be identified")


def test_a_comparison_with_a_run_without_light_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    save_model(default_model(), tmp_path / "m.yaml")
    (tmp_path / "dark.csv").write_text("\n".join(_dark(_rows())) + "\n", encoding="utf-8")
    assert main(["compare", "dark.csv", "--model", "m.yaml"]) == 0
    assert "dark: the laser power never changes" in capfd.readouterr().err


@pytest.mark.parametrize("case", MODEL)
def test_a_model_file_that_is_wrong(case: str, tmp_path: Path, refused: Callable[[list[str], str], None]) -> None:
    change, told = MODEL[case]
    save_model(default_model(), tmp_path / "m.yaml")
    content = yaml.safe_load((tmp_path / "m.yaml").read_text(encoding="utf-8"))
    change(content)
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    (tmp_path / "run.csv").write_text("\n".join(_rows()) + "\n", encoding="utf-8")
    refused(["compare", "run.csv", "--model", "m.yaml", "--report", "r.html"], told)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A good recording of a few seconds."""
    folder = tmp_path_factory.mktemp("bag") / "run"
    done = lce("run", "pulse:th=2,rest=2", "--fast", "--out", str(folder))
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize(("kept", "told"), [(0.0, "run"), (0.5, "lce repair")])
def test_a_bag_that_is_empty_or_cut_off(
    kept: float, told: str, bag: Path, tmp_path: Path, refused: Callable[[list[str], str], None]
) -> None:
    broken = tmp_path / "run"
    broken.mkdir()
    for file in bag.iterdir():
        data = file.read_bytes()
        (broken / file.name).write_bytes(data[: int(kept * len(data))] if file.suffix == ".mcap" else data)
    refused(["fit", "run", "--out", "m.yaml"], told)


def test_runs_of_two_strips(
    bag: Path, tmp_path: Path, command: Callable[..., list[str]], refused: Callable[[list[str], str], None]
) -> None:
    for name, length_m in (("short", 0.01), ("long", 0.02)):
        shutil.copytree(bag, tmp_path / name)
        about = yaml.safe_load((bag / "experiment.yaml").read_text(encoding="utf-8"))
        about["conditions"]["strip_length_m"] = length_m
        (tmp_path / name / "experiment.yaml").write_text(yaml.safe_dump(about), encoding="utf-8")
    refused(command("short", "long"), "long: ")


def test_a_table_of_another_strip_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    other = default_model().set({"lumped.gain": 22.0})
    for name, strip in (("one", default_model()), ("two", default_model()), ("stranger", other)):
        (tmp_path / f"{name}.csv").write_text("\n".join(_rows(strip)) + "\n", encoding="utf-8")
    assert main(["fit", "one.csv", "two.csv", "--deformation", "none", "--out", "same.yaml"]) == 0
    assert "all runs" not in capfd.readouterr().err
    assert main(["fit", "one.csv", "two.csv", "stranger.csv", "--deformation", "none", "--out", "m.yaml"]) == 0
    (told,) = [line for line in capfd.readouterr().err.splitlines() if "does not serve all runs" in line]
    assert "one value of lumped.gain" in told and "farthest from the others is stranger" in told


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["run", "puls:th=2", "--fast", "--out", "o"], "unknown protocol 'puls:th=2'"),
        (["run", "pulse:th=two", "--fast", "--out", "o"], "th = 'two' is not a number"),
        (["run", "pulse", "--fast", "--set", "lumped.tau=-1", "--out", "o"], "lumped.tau: -1 s"),
        (["fit", "nowhere", "--out", "m.yaml"], "nowhere: no such file or folder"),
        (["simulate", "--model", "nowhere.yaml", "--input", "w.csv", "--out", "o.csv"], "nowhere.yaml"),
    ],
)
def test_words_that_mean_nothing(words: list[str], told: str, refused: Callable[[list[str], str], None]) -> None:
    refused(words, told)
