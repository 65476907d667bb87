# SPDX-License-Identifier: Apache-2.0
"""`lce effects`, and effects on the way through the other commands. Files of one's own: test/test_own_effect.py."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from lce_app.cli import main as cli
from lce_model import default_model, load_model, save_model
from lce_model.effects import library

ROOT = Path(__file__).resolve().parents[3]


def test_the_library_as_a_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["effects"]) == 0
    told = capsys.readouterr().out
    for effect in library().values():
        assert effect.name in told and effect.equation in told


def test_one_effect_with_equation_units_bounds_and_sources(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["effects", "creep"]) == 0
    told = capsys.readouterr().out
    for word in ("stage strain", "tau_v dd_c/dt = d - d_c", "10 (0.1 to 1000) s", "null at 0", "d3sm00770g"):
        assert word in told


def test_an_unknown_effect_is_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["effects", "crep"]) == 1
    assert "unknown effect 'crep' (did you mean 'creep'?); known: ambient_drift," in capsys.readouterr().err


def test_docs_effects_is_what_the_command_writes(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["effects", "--markdown"]) == 0
    assert (ROOT / "docs" / "reference" / "effects.md").read_text(encoding="utf-8") == capsys.readouterr().out


def test_a_setting_brings_its_effect_and_a_fit_finds_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    strip, run, fitted = tmp_path / "strip.yaml", tmp_path / "run.csv", tmp_path / "fitted.yaml"
    save_model(default_model("lumped", "none"), strip)
    made = ["simulate", "--model", str(strip), "--input", "ramp:high=2,up=20,down=20,rest=40", "--out", str(run)]
    assert cli.main([*made, "--set", "radiation.emissivity=0.6"]) == 0
    bare = ["fit", str(run), "--deformation", "none", "--out", str(fitted)]
    assert cli.main([*bare, "--effect", "radiation", "--fix", "ambient.t_env"]) == 0
    assert "radiation.emissivity" in capsys.readouterr().out
    entry = yaml.safe_load(fitted.read_text())["parameters"]["radiation"]["emissivity"]
    assert entry["unit"] == "1" and entry["bounds"] == [0.0, 1.0]
    assert entry["value"] == pytest.approx(0.6, abs=0.01)
    assert load_model(fitted).effects == ("radiation",)


def test_a_simulated_run_shows_what_the_sensors_show(tmp_path: Path) -> None:
    strip = tmp_path / "strip.yaml"
    save_model(default_model(), strip)
    columns = []
    for name, more in (("true", []), ("late", ["--set", "camera_lag.tau=0.5"])):
        out = tmp_path / f"{name}.csv"
        wave = "hold:power=1.5,hold=10,rest=5"
        assert cli.main(["simulate", "--model", str(strip), "--input", wave, "--out", str(out), *more]) == 0
        columns.append(np.loadtxt(out, delimiter=",", skiprows=1, usecols=(2, 3)))
    true, late = columns
    assert np.abs(true[:, 0] - late[:, 0]).max() > 0.5
    np.testing.assert_array_equal(true[:, 1], late[:, 1])
