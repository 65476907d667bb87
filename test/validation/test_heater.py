# SPDX-License-Identifier: Apache-2.0
"""docs/results/heater.md, run as it stands on the measured data, where they lie beside the repository."""

import re
import shlex
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path

import heater
import pytest
import walk
from heater_splits import MISSING, diagnosed, splits

from lce_app.cli.main import main
from lce_data.read_runs import read_run
from lce_model import load_model

PAGE = (heater.REPOSITORY / "docs" / "results" / "heater.md").read_text(encoding="utf-8")
DATA = heater.find()

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        DATA is None,
        reason="no heater runs: git clone the source that docs/results/heater.md names",
    ),
    pytest.mark.timeout(300),  # the first test waits for all commands of the page
]


def blocks(kind: str) -> list[str]:
    """The code blocks of one kind, in their order."""
    return walk.blocks(PAGE, kind)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The runs of the page."""
    assert DATA is not None
    place = tmp_path_factory.mktemp("page")
    walk.as_downloaded(DATA, place)
    walk.run(blocks("bash"), place)
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
    times_noise = dict(re.findall(r"^(sin_\w+) .* ([\d.]+) +[\d.]+%$", printed[2], re.MULTILINE))
    assert len(times_noise) == 3
    assert min(map(float, times_noise.values())) > 15.0


def test_a_second_mass_is_missing_and_the_runs_differ(printed: list[str]) -> None:
    assert printed[3].startswith("second_mass is missing: ")
    assert printed[3].count(" is missing: ") == 1
    assert "ambient.t_env (temperature of the surroundings T_env) differs from run to run: " in printed[3]
    _, before, after = over_noise(printed[3], "training: 5 runs")
    assert after < 0.2 * before
    _, before, after = over_noise(printed[3], "held out: sin_5_50_run_1")
    assert after < 0.7 * before


def test_the_model_with_both_describes_every_run(folder: Path, printed: list[str]) -> None:
    model = load_model(folder / "m2.yaml")
    assert min(model["second_mass.tau"], model["lumped.tau"]) == pytest.approx(17.0, abs=3.0)
    assert set(model.varies) == {"ambient.t_env", "lumped.tau"}
    nrmse = dict(re.findall(r"^(s\w+) +T .* [\d.]+ +([\d.]+)%$", printed[5], re.MULTILINE))
    assert len(nrmse) == 6
    assert float(nrmse.pop("sin_5_50_run_1")) < 20.0
    assert max(map(float, nrmse.values())) < 10.0


@pytest.mark.parametrize(
    "train",
    [
        ("sin_5_50_run_1", "step_50_run_1", "step_50_run_2"),
        ("sin_2_50_run_1", "step_50_run_1"),
        ("sin_2_50_run_1", "sin_5_50_run_2", "step_50_run_1", "step_50_run_2", "step_50_run_3"),
    ],
)
def test_no_other_effect_is_named_on_any_split(folder: Path, train: tuple[str, ...]) -> None:
    runs = {name: read_run(folder / "heater" / f"{name}.csv") for name in heater.RUNS}
    held_out = [run for name, run in runs.items() if name not in train]
    found = diagnosed([runs[name] for name in train], held_out)
    assert {step.added for step in found.steps} <= {MISSING}
    found = diagnosed([runs[name] for name in train], held_out, without=MISSING)
    assert found.steps == () and found.verdict in ("unexplained", "cannot_tell")


def test_the_page_tells_what_make_heater_tries() -> None:
    everything = len(splits(heater.RUNS))
    assert everything == 56
    assert f"all {everything} ways" in " ".join(PAGE.split())
