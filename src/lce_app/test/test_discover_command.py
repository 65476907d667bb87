# SPDX-License-Identifier: Apache-2.0
"""`lce discover` from files to files: what it writes is an effect that the other commands take."""

import json
from pathlib import Path

import numpy as np
import pytest

from lce_app.cli.main import main as lce
from lce_data.units import KELVIN
from lce_model import default_model, save_model

AMBIENT_C, GAIN, TAU_S = 24.0, 45.0, 12.0


def _recorded(path: Path, power: np.ndarray, seed: int) -> str:
    """A CSV of a heater that also loses heat by T⁴; Heun's method, 10 samples a second."""
    noise = 0.05 * np.random.default_rng(seed).standard_normal(power.size)
    ambient = AMBIENT_C + KELVIN
    seen = [ambient]

    def rate(kelvin: float, watt: float) -> float:
        return (GAIN * watt - (kelvin - ambient)) / TAU_S - 4e-10 * (kelvin**4 - ambient**4)

    for watt in power[:-1]:
        first = rate(seen[-1], watt)
        seen.append(seen[-1] + 0.05 * (first + rate(seen[-1] + 0.1 * first, watt)))
    rows = [
        f"{0.1 * i:.1f},{p:.3f},{k - KELVIN + e:.4f}"
        for i, (p, k, e) in enumerate(zip(power, seen, noise, strict=True))
    ]
    path.write_text("\n".join(["time_s,power_w,temperature_c", *rows]) + "\n")
    return str(path)


@pytest.fixture
def runs(tmp_path: Path) -> list[str]:
    time = np.arange(0.0, 80.0, 0.1)
    waves = {
        "pulse": np.where((time > 2.0) & (time < 30.0), 1.3, 0.0),
        "stairs": 0.3 * np.floor(time / 14.0) % 1.5,
        "other": np.where(np.sin(0.41 * time) + np.sin(0.97 * time) > 0.2, 1.4, 0.1),
    }
    return [_recorded(tmp_path / f"{name}.csv", power, i) for i, (name, power) in enumerate(waves.items())]


def test_what_is_found_is_an_effect_that_can_be_added(
    runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, found = tmp_path / "m.yaml", tmp_path / "found.py"
    numbers, report = tmp_path / "d.json", tmp_path / "d.html"
    save_model(default_model("lumped", "none"), model)
    asked = [*runs[:2], "--test", runs[2], "--model", str(model)]
    assert lce(["discover", *asked, "--out", str(found), "--json", str(numbers), "--report", str(report)]) == 0
    told = capsys.readouterr().out
    assert "The heat balance has too much by" in told and "confirmed on other" in told
    assert f"lce add {found}" in told
    assert "The heat balance has too much by" in report.read_text(encoding="utf-8")
    record = json.loads(numbers.read_text())
    assert record["verdict"] == "found" and record["closures"][0]["place"] == "heat"

    assert lce(["effects", str(found)]) == 0
    assert "Found in pulse, stairs." in capsys.readouterr().out
    assert lce(["add", str(found), *asked, "--out", str(tmp_path / "m2.yaml")]) == 0
    assert "confirmed on other" in capsys.readouterr().out


def test_a_model_that_is_not_there_is_refused(runs: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert lce(["discover", runs[0], "--model", "nowhere.yaml", "--out", "found.py"]) == 1
    assert "nowhere.yaml: No such file" in capsys.readouterr().err


def test_an_effect_file_that_no_command_would_take_is_refused(
    runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "m.yaml"
    save_model(default_model("lumped", "none"), model)
    assert lce(["discover", runs[0], "--model", str(model), "--out", "found.txt"]) == 1
    assert "found.txt: an effect file must end in .py" in capsys.readouterr().err


def test_the_file_to_write_has_to_be_named(runs: list[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        lce(["discover", runs[0], "--model", "m.yaml"])
    assert refused.value.code == 2
