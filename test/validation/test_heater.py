# SPDX-License-Identifier: Apache-2.0
"""docs/heater.md, run as it stands on the measured data, where they lie beside the repository."""

import re
import shlex
from contextlib import chdir, redirect_stdout
from io import StringIO
from pathlib import Path

import heater
import pytest
import yaml

from lce_app.cli.main import main
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
    found = re.findall(r"^```(.*?)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == kind]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The runs and the effect of the page."""
    assert DATA is not None
    place = tmp_path_factory.mktemp("page")
    (place / "heater").mkdir()
    heater.convert_all(DATA, place / "heater")
    (effect,) = blocks("python")
    (place / "sensor_lag.py").write_text(effect, encoding="utf-8")
    return place


@pytest.fixture(scope="module")
def printed(folder: Path) -> list[str]:
    """What each `lce` command of the page prints, without the last one."""
    lines = [line for block in blocks("") for line in block.splitlines() if line.startswith("lce ")]
    said = []
    with chdir(folder):
        for command in lines[:-1]:
            words = shlex.split(command)[1:]
            expanded = [sorted(str(p) for p in Path().glob(w)) if "*" in w else [w] for w in words]
            with redirect_stdout(StringIO()) as out:
                assert main([word for part in expanded for word in part]) == 0
            said.append(out.getvalue())
    return said


def held_out(diagnosis: str) -> tuple[float, float]:
    """NRMSE [%] of the held-out run, before and after."""
    found = re.search(r"test temperature +([\d.]+)% +([\d.]+)%", diagnosis)
    assert found, diagnosis
    return float(found[1]), float(found[2])


def test_a_lumped_model_follows_the_steps_and_misses_the_sines(printed: list[str]) -> None:
    nrmse = dict(re.findall(r"^(\w+_run_\d) .*?([\d.]+)% ", printed[1], re.MULTILINE))
    assert all(float(nrmse[f"sin_5_50_run_{i}"]) > 20.0 for i in (1, 2)), printed[1]
    assert all(float(nrmse[f"step_50_run_{i}"]) < 7.0 for i in (1, 2)), printed[1]


def test_the_library_holds_no_lag_that_is_slow_enough(printed: list[str]) -> None:
    assert printed[2].startswith("Something is missing that the library does not hold")
    before, after = held_out(printed[2])
    assert before > 20.0
    assert after > 15.0


def test_a_lag_of_ones_own_is_named_first_and_mends_the_run_that_was_held_out(printed: list[str]) -> None:
    assert printed[3].startswith("sensor_lag is missing")
    _, after = held_out(printed[3])
    assert after < 3.0


def test_the_added_effects_and_their_history(folder: Path, printed: list[str]) -> None:
    assert "on runs left out too" in printed[4]
    model = load_model(folder / "m3.yaml")
    assert model["sensor_lag.tau"] == pytest.approx(16.5, abs=1.0)
    assert model.effect_names == ("sensor_lag", "laser_saturation")
    history = yaml.safe_load((folder / "m3.yaml").read_text(encoding="utf-8"))["fit"]["history"]
    errors = [entry["test"]["temperature_nrmse"] for entry in history]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.03


def test_what_the_steps_alone_cannot_tell(printed: list[str]) -> None:
    assert re.search(r"ambient.t_env +[\d.]+ K +not determined", printed[6]), printed[6]
    assert re.search(r"change together .*ambient.t_env.*lumped.gain", printed[6]), printed[6]


def test_which_curvature_two_sines_and_a_step_cannot_tell(printed: list[str]) -> None:
    assert printed[8].startswith("sensor_lag is missing")
    curved = {"natural_convection", "laser_saturation", "radiation"}
    told = re.findall(r"^(\w+) is missing.* cannot tell it from ([^;]*);", printed[8], re.MULTILINE)
    assert any(len(curved & {name, *others.split(", ")}) >= 2 for name, others in told), printed[8]
    (unseen,) = re.findall(r"would not show.*: (.*)\.", printed[8])
    assert "emissivity_error" in unseen.split(", ")
