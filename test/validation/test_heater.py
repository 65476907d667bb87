# SPDX-License-Identifier: Apache-2.0
"""docs/heater.md, run as it stands on the measured data, where they lie beside the repository."""

import re
import shlex
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path

import heater
import pytest
import walk
import yaml
from heater_splits import diagnosed, splits

from lce_app.cli.main import main
from lce_data.read_runs import read_run
from lce_model import load_model

PAGE = (heater.REPOSITORY / "docs" / "heater.md").read_text(encoding="utf-8")
DATA = heater.find()

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        DATA is None,
        reason="no heater runs: git clone the source that docs/heater.md names",
    ),
    pytest.mark.timeout(300),  # the first test waits for all commands of the page
]


def blocks(kind: str) -> list[str]:
    """The code blocks of one kind, in their order."""
    return walk.blocks(PAGE, kind)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The runs and the effect of the page."""
    assert DATA is not None
    place = tmp_path_factory.mktemp("page")
    walk.as_downloaded(DATA, place)
    walk.run(blocks("bash"), place)
    (effect,) = blocks("python")
    (place / "sensor_lag.py").write_text(effect, encoding="utf-8")
    return place


@pytest.fixture(scope="module")
def printed(folder: Path) -> list[str]:
    """What each `lce` command of the page prints."""
    lines = [line for block in blocks("") for line in block.splitlines() if line.startswith("lce ")]
    said = []
    with chdir(folder):
        for command in lines:
            words = shlex.split(command)[1:]
            expanded = [sorted(str(p) for p in Path().glob(w)) if "*" in w else [w] for w in words]
            with redirect_stdout(StringIO()) as out:
                assert main([word for part in expanded for word in part]) == 0
            said.append(out.getvalue())
    return said


def over_noise(printed: str, runs: str) -> list[float]:
    """RMS errors of a row of a table, in units of the noise: as given, refitted, and with what was added."""
    found = re.search(rf"^{re.escape(runs)} +T +([\d. ]+)", printed, re.MULTILINE)
    assert found, printed
    return [float(word) for word in found[1].split() if "." in word]


def test_what_the_steps_alone_cannot_tell(printed: list[str]) -> None:
    assert re.search(r"ambient.t_env +[\d.]+ K +not determined", printed[0]), printed[0]
    assert re.search(r"change together .*ambient.t_env.*lumped.gain", printed[0]), printed[0]


def test_a_lumped_model_misses_the_sines(printed: list[str]) -> None:
    times_noise = dict(re.findall(r"^(sin_\w+) .* ([\d.]+)$", printed[2], re.MULTILINE))
    assert len(times_noise) == 3
    assert min(map(float, times_noise.values())) > 15.0


def test_the_library_holds_nothing_that_explains_it(printed: list[str]) -> None:
    assert printed[3].startswith("Something is missing that the library does not hold")
    assert "is missing: " not in printed[3]


def test_a_lag_of_ones_own_is_named_and_mends_the_run_that_was_held_out(printed: list[str]) -> None:
    assert printed[4].startswith("sensor_lag is missing: a thermistor follows the heater late; confirmed on ")
    assert printed[4].count("is missing: ") == 1
    _, before, after = over_noise(printed[4], "held out: sin_5_50_run_1")
    assert before > 15.0
    assert after < 3.0


def test_the_added_effect_and_the_history(folder: Path, printed: list[str]) -> None:
    assert "confirmed on sin_5_50_run_1: T " in printed[5].splitlines()[0]
    assert (
        over_noise(printed[5], "sin_5_50_run_1 (held out)")[-1]
        == over_noise(printed[4], "held out: sin_5_50_run_1")[-1]
    )
    model = load_model(folder / "m2.yaml")
    assert model["sensor_lag.tau"] == pytest.approx(16.5, abs=1.0)
    assert model.effect_names == ("sensor_lag",)
    history = yaml.safe_load((folder / "m2.yaml").read_text(encoding="utf-8"))["fit"]["history"]
    errors = [entry["test"]["temperature_nrmse"] for entry in history]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.03


def test_what_is_left_then_is_not_in_the_library_either(printed: list[str]) -> None:
    assert printed[6].startswith("Something is missing that the library does not hold")


def test_each_sine_alone_follows_the_model_with_the_lag(folder: Path, printed: list[str]) -> None:
    assert len(printed) == 10
    fast, slow, again = (load_model(folder / f"{name}.yaml") for name in "abc")
    assert slow["lumped.gain"] == pytest.approx(again["lumped.gain"], rel=0.05)
    assert fast["lumped.gain"] < 0.95 * again["lumped.gain"]
    for said in printed[7:]:
        (nrmse,) = re.findall(r"^sin_\w+ +([\d.]+)%", said, re.MULTILINE)
        assert float(nrmse) < 5.0


@pytest.mark.parametrize(
    "train",
    [
        ("sin_5_50_run_1", "step_50_run_1", "step_50_run_2"),
        ("sin_2_50_run_1", "step_50_run_1"),
        ("sin_2_50_run_1", "sin_5_50_run_2", "step_50_run_1", "step_50_run_2", "step_50_run_3"),
    ],
)
def test_no_effect_is_named_on_any_split(folder: Path, train: tuple[str, ...]) -> None:
    runs = {name: read_run(folder / "heater" / f"{name}.csv") for name in heater.RUNS}
    found = diagnosed([runs[name] for name in train], [run for name, run in runs.items() if name not in train])
    assert found.verdict in ("unexplained", "cannot_tell")
    assert found.steps == ()


def test_the_page_tells_what_make_heater_wrote() -> None:
    written = (heater.REPOSITORY / "docs" / "heater-splits.md").read_text(encoding="utf-8")
    everything = len(splits(heater.RUNS))
    assert everything == 56
    assert f"**0 of {everything} splits named an effect** (bar: none)." in written
    assert f"all {everything} ways" in " ".join(PAGE.split())
