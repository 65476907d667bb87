# SPDX-License-Identifier: Apache-2.0
"""`lce diagnose`, `lce add` and `lce design` from files to files."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lce_app.cli.main import main as lce
from lce_app.use_cases.diagnose import _own
from lce_data.errors import LceError
from lce_data.units import KELVIN
from lce_model import default_model, load_model, save_model, simulate
from lce_model.effects import find

STRIP = default_model().add("creep").set({"creep.share": 0.12, "creep.tau_v": 8.0})


def _recorded(path: Path, power: np.ndarray, seed: int) -> Path:
    """A CSV of the strip: camera at 10 Hz, distance at 100 Hz."""
    rng = np.random.default_rng(seed)
    time = np.arange(power.size) / 100.0
    made = simulate(STRIP, time, power)
    temperature = made.measured_temperature_k - KELVIN + 0.06 * rng.standard_normal(time.size)
    displacement = made.measured_displacement_m + 4e-6 * rng.standard_normal(time.size)
    rows = [
        f"{t:.2f},{p:.3f},{f'{k:.3f}' if i % 10 == 0 else ''},{d:.8f}"
        for i, (t, p, k, d) in enumerate(zip(time, power, temperature, displacement, strict=True))
    ]
    path.write_text("\n".join(["time_s,power_w,temperature_c,displacement_m", *rows]) + "\n")
    return path


@pytest.fixture
def runs(tmp_path: Path) -> list[str]:
    """Two runs to learn from and one that is held out."""
    time = np.arange(0.0, 45.0, 0.01)
    pulse = np.where((time > 1.0) & (time < 16.0), 2.3, 0.0)
    stairs = np.select([time < 10.0, time < 18.0, time < 26.0], [1.0, 2.2, 1.2], 0.0)
    other = np.select([time < 7.0, time < 14.0, time < 24.0], [2.4, 0.5, 2.0], 0.0)
    waves = {"pulse": pulse, "stairs": stairs, "other": other}
    return [str(_recorded(tmp_path / f"{name}.csv", p, i)) for i, (name, p) in enumerate(waves.items())]


@pytest.mark.slow
def test_from_a_misfit_to_a_model_that_predicts_a_run_it_never_saw(
    runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, better = tmp_path / "m.yaml", tmp_path / "m2.yaml"
    numbers, report, second = tmp_path / "d.json", tmp_path / "d.html", tmp_path / "a.html"
    save_model(default_model(), model)
    train, test = runs[:2], ["--test", runs[2]]
    asked = ["--model", str(model), "--json", str(numbers), "--report", str(report)]
    assert lce(["diagnose", *train, *test, *asked]) == 0
    record = json.loads(numbers.read_text())
    assert record["verdict"] == "missing"
    assert record["added"] == ["creep"]
    assert "creep is missing" in capsys.readouterr().out
    assert "creep is missing" in report.read_text(encoding="utf-8")

    assert (
        lce(["add", "creep", *train, *test, "--model", str(model), "--out", str(better), "--report", str(second)]) == 0
    )
    out = capsys.readouterr().out
    assert "lumped + equilibrium + creep" in out
    mended = load_model(better)
    assert mended.effects == ("creep",)
    assert mended["creep.share"] == pytest.approx(0.12, abs=0.02)
    history = mended.fit["history"]
    assert history[1]["test"]["displacement_nrmse"] < 0.3 * history[0]["test"]["displacement_nrmse"]
    assert "creep added" in second.read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_designed_wave_is_one_that_can_be_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, wave = tmp_path / "m.yaml", tmp_path / "wave.csv"
    save_model(STRIP, model)
    limits = ["--max-power", "2", "--max-temperature", "80", "--duration", "40"]
    assert lce(["design", "--model", str(model), "--between", "creep,phase_kinetics", *limits, "--out", str(wave)]) == 0
    assert "standard" in capsys.readouterr().out
    table = np.loadtxt(wave, delimiter=",", skiprows=1)
    assert table[-1, 0] <= 41.0
    assert 0.0 < table[:, 1].max() <= 2.0
    assert simulate(STRIP, table[:, 0], table[:, 1]).temperature_k.max() < 80.0 + KELVIN + 0.5


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["diagnose", "{run}", "--model", "nowhere.yaml"], "nowhere.yaml: No such file"),
        (["add", "creeep", "{run}", "--model", "{model}", "--out", "{out}"], "unknown effect 'creeep'"),
        (["add", "./none.py", "{run}", "--model", "{model}", "--out", "{out}"], "no such effect file"),
        (["design", "--model", "{model}", "--between", "creep", "--out", "{out}"], "expected two effects"),
        (["design", "--model", "{model}", "--between", "creep,creep", "--out", "{out}"], "are one effect"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_writes_nothing(
    words: list[str], told: str, runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, out = tmp_path / "m.yaml", tmp_path / "out"
    save_model(default_model(), model)
    assert lce([w.format(run=runs[0], model=model, out=out) for w in words]) == 1
    error = capsys.readouterr().err.splitlines()
    assert len(error) == 1
    assert told in error[0]
    assert not out.exists()


def test_an_effect_of_ones_own_has_a_name_of_its_own() -> None:
    creep = find("creep")
    mine = replace(creep, name="mine", path="/tmp/mine.py")
    assert _own([creep, mine, mine]) == [mine]
    with pytest.raises(LceError, match=r"^/tmp/mine\.py: its name creep is that of an effect of the library"):
        _own([replace(mine, name="creep")])
