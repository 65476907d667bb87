# SPDX-License-Identifier: Apache-2.0
"""`lce tune`: gains out, in the form that the nodes read, tried on the running nodes where that is asked for."""

from functools import partial
from pathlib import Path

import pytest
import yaml

from lce_app.cli import main as cli
from lce_control.tuning import options
from lce_control.tuning.tasks import INNER, OUTER, SINGLE
from lce_experiment.config import config_file, default_strip
from lce_model import load_model, save_model

SHORT = partial(options.TuneOptions, generations=2, candidates=2, local_tries=30, shares=(0.45, 0.9))


@pytest.fixture(autouse=True)
def short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(options, "TuneOptions", SHORT)


def gains(path: Path) -> dict[str, dict[str, float]]:
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    return {name.removeprefix("/**/"): entry["ros__parameters"] for name, entry in content.items()}


def test_gains_in_the_form_of_control_yaml_and_a_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, report = tmp_path / "gains.yaml", tmp_path / "tuned.html"
    words = ["tune", "--out", str(out), "--overshoot", "0.2", "--undershoot", "0.2", "--report", str(report)]
    assert cli.main(words) == 0
    found, shipped = gains(out), gains(config_file("control.yaml"))
    assert set(found) == {OUTER, INNER, SINGLE}
    for node, own in found.items():
        assert set(own) <= set(shipped[node]), "control.yaml says the same of every gain"
        assert all(value > 0.0 for value in own.values())
    printed = capsys.readouterr().out
    assert [line.split()[0] for line in printed.splitlines()[1:4]] == ["inner", "double", "single"]
    text = report.read_text(encoding="utf-8")
    for said in ("overshoot ≤ 20.0%", "open single loop, phase", "Double loop", f"{found[SINGLE]['kp']:g}"):
        assert said in text


def test_on_the_bench_the_running_nodes_are_what_is_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A strip that heats a tenth less: one experiment tells what the gains of the model do there."""
    monkeypatch.setattr(options, "TuneOptions", partial(SHORT, shortest_s=10.0, longest_s=10.0))
    strip, words = tmp_path / "strip.yaml", ["tune", "--overshoot", "0.3", "--undershoot", "0.3", "--shake", "0.1"]
    save_model(load_model(default_strip()).set({"lumped.gain": 66.0}), strip)
    assert cli.main([*words, "--out", str(tmp_path / "model.yaml")]) == 0
    _, inner, double, single, *_ = capsys.readouterr().out.splitlines()
    on_the_bench = ["--bench", str(strip), "--experiments", "1", "--out", str(tmp_path / "bench.yaml")]
    assert cli.main([*words, *on_the_bench]) == 0
    _, *there = capsys.readouterr().out.splitlines()
    assert gains(tmp_path / "bench.yaml") == gains(tmp_path / "model.yaml")
    assert there[0] == inner
    for before, after in ((double, there[1]), (single, there[2])):
        assert float(after.split()[1]) > float(before.split()[1]) + 0.1, "rises later"


def test_requirements_that_cannot_be_met_are_one_line_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["tune", "--out", str(tmp_path / "gains.yaml"), "--rise", "0.5"]) == 1
    errors = capsys.readouterr().err
    assert "inner: no gains found that meet the requirements; the best have" in errors
    assert "rise_s 3.81 instead of 0.5" in errors and list(tmp_path.iterdir()) == []
