# SPDX-License-Identifier: Apache-2.0
"""The `lce` command: quick help, honest exit status, one line for what the user can put right."""

import argparse
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from lce_app.cli import main as cli
from lce_data.units import KELVIN
from lce_model import default_model, load_model, save_model, simulate

LCE = [sys.executable, "-m", "lce_app.cli.main"]


SLOW = {"numba", "scipy", "numpy", "polars", "rosbags", "rclpy", "nicegui", "tqdm", "yaml"}
"""Packages that take long to import, all in all seconds."""


def imported(*words: str, status: int = 0) -> tuple[set[str], str]:
    """Top-level packages that a command imports, and what it prints."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", *LCE[1:], *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == status, done.stderr
    lines = done.stderr.splitlines()
    names = {line.rpartition("|")[2].strip().partition(".")[0] for line in lines if line.startswith("import time:")}
    rest = "\n".join(line for line in lines if not line.startswith("import time:"))
    return names, done.stdout + rest


def test_help_names_every_command_and_imports_nothing_slow() -> None:
    names, said = imported("--help")
    assert not names & SLOW
    assert all(f"\n    {name} " in said for name in cli.COMMANDS)


@pytest.mark.parametrize(
    ("words", "missing"),
    [
        ("compare nosuch.csv --model m.yaml", "nosuch.csv: no such file or folder"),
        ("fit nosuch.csv --out m.yaml", "nosuch.csv: no such file or folder"),
        ("diagnose nosuch.csv --model m.yaml", "nosuch.csv: no such file or folder"),
        ("import nosuch.csv --out runs", "nosuch.csv: no such file or folder"),
        ("add creep nosuch.csv --model m.yaml --out m2.yaml", "nosuch.csv: no such file or folder"),
        ("design --model nosuch.yaml --between creep,radiation --out w.csv", "nosuch.yaml: No such file"),
        ("simulate --model nosuch.yaml --input pulse --out run.csv", "nosuch.yaml: No such file"),
        ("control 1 --model nosuch.yaml", "nosuch.yaml: No such file"),
        ("control 1 --gains nosuch.yaml", "nosuch.yaml: no such file"),
        ("tune --model nosuch.yaml --out gains.yaml", "nosuch.yaml: No such file"),
        (f"compare {'long' * 100}.csv --model m.yaml", "long.csv: no such file or folder"),
        (f"fit {__file__} --out nosuch/m.yaml", "nosuch/m.yaml: there is no folder nosuch; make it first"),
        (f"compare {__file__} --model {__file__} --json .", ".: is a folder; name a file in it"),
        ("tune --out nosuch/gains.yaml", "nosuch/gains.yaml: there is no folder nosuch"),
    ],
)
def test_a_missing_input_is_refused_before_anything_slow_is_imported(words: str, missing: str) -> None:
    names, said = imported(*words.split(), status=1)
    assert missing in said
    assert not names & SLOW


@pytest.mark.parametrize("name", list(cli.COMMANDS))
def test_every_command_has_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main([name, "--help"])
    assert ended.value.code == 0
    assert cli.COMMANDS[name] in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("name", list(cli.COMMANDS))
def test_the_examples_in_the_help_are_right_usage(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    examples = cli.command_module(name).EXAMPLES
    parser = argparse.ArgumentParser()
    cli.command_module(name).add_arguments(parser)
    for example in examples:
        lce, command, *words = example.split()
        assert (lce, command) == ("lce", name)
        parser.parse_args(words)
    with pytest.raises(SystemExit):
        cli.main([name, "--help"])
    said = capsys.readouterr().out
    assert all(f"\n  {example}\n" in said for example in examples)


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("fitt", "fit"),
        ("effects photobleeching", "photobleaching"),
        ("run puls", "pulse"),
        ("run hold:pwer=1", "power"),
    ],
)
def test_a_mistyped_name_is_answered_with_the_right_one(
    words: str, meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with suppress(SystemExit):
        assert cli.main(words.split()) == 1
    assert f"(did you mean '{meant}'?)" in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["nothing"], ["run"], ["run", "pulse", "--fast", "--realtime"], ["repair"]])
def test_wrong_usage_is_status_2(words: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2


def test_a_reader_that_went_away_is_no_error(tmp_path: Path, model: Path) -> None:
    words = ["simulate", "--model", model, "--input", "pulse", "--out", tmp_path / "run.csv"]
    script = f"{' '.join(LCE)} {' '.join(map(str, words))} | true"
    done = subprocess.run(["sh", "-c", script], capture_output=True, text=True, check=False)
    assert done.stderr == ""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """The default model as a file."""
    save_model(default_model(), tmp_path / "model.yaml")
    return tmp_path / "model.yaml"


def _simulate(tmp_path: Path, model: Path, wave: str, *more: str) -> int:
    return cli.main(["simulate", "--model", str(model), "--input", wave, "--out", str(tmp_path / "run.csv"), *more])


def test_simulate_writes_what_the_model_gives(tmp_path: Path, model: Path) -> None:
    wave = tmp_path / "wave.csv"
    time_s = np.arange(300) / 100
    power_w = np.where(time_s < 2, 1.5, 0.0)
    np.savetxt(wave, np.column_stack([time_s, power_w]), "%.2f", ",", header="time_s,power_w", comments="")
    assert _simulate(tmp_path, model, str(wave)) == 0
    assert (tmp_path / "run.csv").read_text().splitlines()[0] == "time_s,power_w,temperature_c,displacement_m"
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    run = simulate(load_model(model), time_s, power_w)
    np.testing.assert_allclose(table[:, :2], np.column_stack([time_s, power_w]))
    np.testing.assert_allclose(table[:, 2], run.temperature_k - KELVIN, atol=1e-6)
    np.testing.assert_allclose(table[:, 3], run.displacement_m, rtol=1e-8)


def test_simulate_makes_100_hz_of_a_coarse_wave(tmp_path: Path, model: Path) -> None:
    (tmp_path / "wave.csv").write_text("time_s,power_w\n0,1\n1,0\n")
    assert _simulate(tmp_path, model, str(tmp_path / "wave.csv")) == 0
    table = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(np.diff(table[:, 0]), 0.01)
    assert (table[:100, 1] == 1).all() and (table[100:, 1] == 0).all()


def test_simulate_leaves_out_the_stage_that_is_not_there(tmp_path: Path) -> None:
    save_model(default_model(deformation="none"), tmp_path / "model.yaml")
    assert _simulate(tmp_path, tmp_path / "model.yaml", "pulse:th=1,rest=0") == 0
    assert (tmp_path / "run.csv").read_text().startswith("time_s,power_w,temperature_c\n")


def test_simulate_overwrites_only_when_told(tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.csv").write_text("precious")
    assert _simulate(tmp_path, model, "pulse") == 1
    assert "exists already" in capsys.readouterr().err
    assert (tmp_path / "run.csv").read_text() == "precious"
    assert _simulate(tmp_path, model, "pulse", "--force") == 0


@pytest.mark.parametrize(
    ("wave", "more", "said"),
    [
        ("time_s,power_w\n0,nan\n", [], "line 2: '0,nan' is not finite"),
        ("time_s,watt\n0,1\n", [], "no column power_w"),
        ("time_s,power_w\n1,1\n0,1\n", [], "time does not increase"),
        ("time_s,power_w\n0,1\n1,1\n", ["--set", "lumped.tau=-3"], "lumped.tau"),
        ("time_s,power_w\n0,1\n1,1\n", ["--set", "creep.tau=3"], "creep.tau"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    tmp_path: Path, model: Path, capsys: pytest.CaptureFixture[str], wave: str, more: list[str], said: str
) -> None:
    (tmp_path / "wave.csv").write_text(wave)
    assert _simulate(tmp_path, model, str(tmp_path / "wave.csv"), *more) == 1
    out, errors = capsys.readouterr()
    assert out == "" and errors.startswith("lce: ") and errors.count("\n") == 1 and said in errors
    assert not (tmp_path / "run.csv").exists()


def test_a_model_does_not_take_the_place_of_a_recording(
    tmp_path: Path, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    measured = run.read_bytes()
    assert cli.main(["fit", "--out", str(run), str(run)]) == 1
    assert "is a recording, which would be overwritten" in capsys.readouterr().err
    assert run.read_bytes() == measured
    beside = run.with_suffix(".yaml")
    beside.write_text("conditions:\n  ambient_c: 21.0\n", encoding="utf-8")
    assert cli.main(["fit", str(run), "--out", str(beside)]) == 1
    assert "says what is known of a recording" in capsys.readouterr().err


def test_an_error_of_ours_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch, model: Path, tmp_path: Path) -> None:
    def broken(text: str) -> None:
        raise ValueError("a mistake in the program")

    monkeypatch.setattr("lce_experiment.protocols.one", broken)
    with pytest.raises(ValueError, match="a mistake in the program"):
        _simulate(tmp_path, model, "pulse")


@pytest.fixture
def run(tmp_path: Path, model: Path) -> Path:
    """A run of the default model."""
    assert _simulate(tmp_path, model, "pulse:th=10,rest=20") == 0
    return tmp_path / "run.csv"


@pytest.mark.parametrize(
    ("stage", "asked", "given"), [("thermal", "none", "lumped"), ("deformation", "dynamic", "equilibrium")]
)
def test_another_base_model_beside_start_is_wrong_usage(
    run: Path, model: Path, stage: str, asked: str, given: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = run.with_name("m.yaml")
    assert cli.main(["fit", str(run), "--out", str(out), "--start", str(model), f"--{stage}", asked]) == 2
    error = capsys.readouterr().err
    assert f"--{stage} {asked} contradicts the start model {model}, whose {stage} stage is {given}" in error
    assert error.count("\n") == 1 and not out.exists()


def test_start_brings_its_stages_with_it(tmp_path: Path, run: Path) -> None:
    start, out = tmp_path / "start.yaml", tmp_path / "m.yaml"
    save_model(default_model("lumped", "none"), start)
    assert cli.main(["fit", str(run), "--out", str(out), "--start", str(start), "--thermal", "lumped"]) == 0
    assert load_model(out).deformation == "none"


def test_a_start_that_needs_what_no_run_has_is_refused(
    tmp_path: Path, run: Path, model: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [",".join(line.split(",")[:3]) for line in run.read_text().splitlines()]
    (tmp_path / "thermal.csv").write_text("\n".join(rows) + "\n")
    words = ["fit", str(tmp_path / "thermal.csv"), "--out", str(tmp_path / "m.yaml")]
    assert cli.main([*words, "--start", str(model)]) == 1
    assert "has the deformation stage equilibrium" in capsys.readouterr().err
    assert cli.main(words) == 0
    assert "no run has a displacement: fitting the thermal stage alone" in capsys.readouterr().err
    assert load_model(tmp_path / "m.yaml").deformation == "none"
