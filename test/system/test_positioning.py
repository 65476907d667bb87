# SPDX-License-Identifier: Apache-2.0
"""`lce control`: targets in, recordings and figures out, with the real nodes."""

import json
from pathlib import Path

import numpy as np
import pytest
from run_command import experiment, lce, read, values

from lce_app.cli import main as cli
from lce_control.step_metrics import step_metrics
from lce_control.tuning.bang_bang import bang_bang
from lce_data.errors import LceError
from lce_experiment import recording, registry
from lce_experiment.config import config_file
from lce_experiment.nodes.target_player_node import TargetPlayer
from lce_experiment.positioning.reach import check_reach
from lce_model import load_model, save_model
from lce_model.inverse import OutOfReach
from lce_ros.health import Level
from lce_ros.testing import Graph

KEYS = {
    "target_m",
    "rise_time_s",
    "limit_rise_time_s",
    "overshoot",
    "settling_time_s",
    "rmse_after_30s",
    "energy_j",
}


@pytest.fixture(autouse=True)
def _keep_handlers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "interruptible", lambda: None)


@pytest.mark.parametrize("mode", registry.CONTROLLERS)
def test_figures_and_pictures(mode: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    figures, page, strip_file = tmp_path / "figures.json", tmp_path / "page.html", tmp_path / "strip.yaml"
    strip = load_model(config_file("models/strip.yaml")).set({"lumped.gain": 66.0})
    save_model(strip, strip_file)
    targets_mm = (1.0, 2.5) if mode == "single" else (1.0,)
    words = ["control", *map(str, targets_mm), "--mode", mode, "--fast", "--seed", "1", "--hold", "32"]
    words += ["--strip", str(strip_file)]
    assert cli.main([*words, "--out", str(tmp_path / "out"), "--json", str(figures), "--report", str(page)]) == 0
    found = json.loads(figures.read_text(encoding="utf-8"))
    assert found["mode"] == mode and [set(entry) for entry in found["targets"]] == [KEYS] * len(targets_mm)
    printed = capfd.readouterr().out
    for entry, target_mm in zip(found["targets"], targets_mm, strict=True):
        bag = tmp_path / "out" / f"{target_mm:g}mm" if len(targets_mm) > 1 else tmp_path / "out"
        assert str(bag) in printed and f"{entry['rise_time_s']:.2f}" in printed
        time_s, d = values(bag, "/lce/sim/displacement")
        begin_s = read(bag)["/lce/target_displacement"][0][0]
        again = step_metrics((time_s - begin_s)[time_s >= begin_s], d[time_s >= begin_s], 1e-3 * target_mm)
        assert entry["rise_time_s"] == pytest.approx(again.rise_time_s, rel=1e-5)
        assert entry["rmse_after_30s"] == pytest.approx(again.rmse_after_30s, rel=1e-5)
        assert entry["limit_rise_time_s"] <= entry["rise_time_s"] + 0.02
        assert entry["energy_j"] == pytest.approx(values(bag, "/lce/laser/power")[1].sum() * 0.01, rel=1e-3)
    text = page.read_text(encoding="utf-8")
    for panel in ("displacement and target", "temperature and setpoint", "laser power", "error, in percent"):
        assert text.count(f"<figcaption>{panel}") == len(targets_mm)
    best = bang_bang(strip, 1e-3, 10.0)
    limit_s = step_metrics(best.time_s, best.displacement_m, 1e-3).rise_time_s
    assert found["targets"][0]["limit_rise_time_s"] == pytest.approx(limit_s)


def test_a_fault_of_a_controller_ends_the_player_and_a_refused_target_does_not(graph: Graph) -> None:
    graph.add(TargetPlayer, wait_for=["outer_controller"])
    controller = graph.probe("outer_controller")
    graph.connect()
    controller.report(Level.ERROR, "target refused: 9.000 mm is out of reach")
    graph.spin_for(1.1)  # diagnostics come once a second
    controller.report(Level.ERROR, "fault: no displacement for 0.51 s: no setpoint")
    with pytest.raises(LceError, match=r"^target_player: stopped by outer_controller: fault: no displacement"):
        graph.spin_for(2.0)


@pytest.mark.alone
def test_in_real_time_the_nodes_are_processes_and_the_end_is_dark(tmp_path: Path) -> None:
    done = lce(
        "control", "1.5", "--hold", "3", "--seed", "2", "--out", str(tmp_path / "bag"), "--set", "lumped.gain=60",
        "--specimen", "A7", "--condition", "ambient_c=23.5",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    about = experiment(tmp_path / "bag")
    assert (about["outcome"], about["mode"], about["protocol"]) == ("complete", "realtime", "control 1.5 mm, double")
    assert (about["conditions"]["specimen"], about["conditions"]["ambient_c"]) == ("A7", 23.5)
    assert about["model"]["set"] == {"lumped.gain": 60.0} and not any(about["lost"].values())
    _, power_w = values(tmp_path / "bag", "/lce/laser/power")
    assert power_w.max() == 2.0 and power_w[-1] == 0.0
    _, d = values(tmp_path / "bag", "/lce/displacement")
    assert np.abs(d[:20]).max() < 5e-5 and d.max() > 0.3e-3


def test_a_target_for_which_the_laser_is_too_weak_is_out_of_reach() -> None:
    strip = load_model(config_file("models/strip.yaml")).set({"lumped.gain": 10.0})
    with pytest.raises(OutOfReach, match=r"the strip reaches 0\.000 to 1\.0") as refused:
        check_reach(strip, 2e-3, 2.0)
    check_reach(strip, 0.9 * refused.value.upper_m, 2.0)
    with pytest.raises(OutOfReach):
        check_reach(strip, 2e-3, 1.0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["5"], "5.000 mm is out of reach: the strip reaches 0.000 to 3.177 mm"),
        (["1", "-0.2"], "-0.200 mm is out of reach"),
        (["nan"], "out of reach"),
        (["1", "--hold", "0.1"], "--hold 0.1: must be within"),
        (["1", "--gains", "none.yaml"], "none.yaml: no such file"),
        (["1", "--seed", "-1"], "seed -1"),
        (["1", "--model", "none.yaml"], "none.yaml"),
        (["1", "--condition", "23.5"], "--condition 23.5: expected KEY=VALUE"),
    ],
)
def test_a_bad_request_is_one_line_and_nothing_is_written(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["control", "--fast", "--out", "bag", *words]) == 1
    out, errors = capsys.readouterr()
    assert out == "" and errors.startswith("lce: ") and errors.count("\n") == 1 and said in errors
    assert list(tmp_path.iterdir()) == []
