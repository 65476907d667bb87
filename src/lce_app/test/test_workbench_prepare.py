# SPDX-License-Identifier: Apache-2.0
"""Runs that the workbench prepares by recipes, and decisions that are taken back."""

import asyncio
import json
import shlex
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
import yaml
from nicegui import ui
from nicegui.testing import User
from test_workbench import STRIP, record, tell

from lce_app.cli.main import main as lce
from lce_app.use_cases.fit import ModelChoice
from lce_app.workbench import archive, command_lines, drawings, tasks
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.tabs.compare import run_figures
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.preparing.recipe import Recipe
from lce_data.preparing.steps import Cut, Detrend, Merge, Resample
from lce_data.progress import silent
from lce_report import Lines

TIME = np.arange(0.0, 20.0, 0.01)
RECIPE: Recipe = (Cut(8.0, 9.5), Resample(0.05))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Two runs, and the temperature of a third one alone."""
    record(tmp_path / "pulse.csv", np.where((TIME > 1.0) & (TIME < 8.0), 2.3, 0.0), 1)
    record(tmp_path / "stairs.csv", np.select([TIME < 5.0, TIME < 12.0], [1.0, 2.2], 0.0), 2)
    rows = "".join(f"{t:.2f},{25.0 + t:.3f}\n" for t in TIME[::10])
    (tmp_path / "camera.csv").write_text(f"time_s,temperature_c\n{rows}")
    (tmp_path / "laser.csv").write_text("time_s,power_w\n" + "".join(f"{t:.2f},{0.1 * (t > 1)}\n" for t in TIME[::10]))
    return tmp_path


def opened(folder: Path) -> WorkbenchState:
    state = WorkbenchState(folder)
    if state.session.current is None:
        state.keep(STRIP.without("creep"), "by hand")
    asyncio.run(state.open())
    return state


def test_everything_uses_the_prepared_run_and_the_recording_stays(folder: Path) -> None:
    before = (folder / "pulse.csv").read_bytes()
    state = opened(folder)
    whole = state.comparison()
    asyncio.run(state.prepare("pulse.csv", RECIPE))
    run = state.runs("train")["pulse.csv"]
    assert run.series[DISPLACEMENT].time_s.size < 400 and run.name == "pulse"
    cut = state.comparison()
    assert whole is not None and cut is not None and cut is not whole
    shown = next(found.run for found in cut.runs if found.run.name == "pulse")
    assert shown.series[DISPLACEMENT] is run.series[DISPLACEMENT]
    assert run_figures(state, "pulse.csv")
    assert (folder / "pulse.csv").read_bytes() == before

    file = state.paths("train")[0]
    assert file.is_relative_to(state.session.prepared) and file.name == "pulse.csv"
    tasks.fit([file], ModelChoice("lumped", "equilibrium"), folder / "fitted.yaml", progress=silent)
    again = WorkbenchState(folder)
    asyncio.run(again.open())
    found = again.runs("train")["pulse.csv"]
    assert np.array_equal(found.series[TEMPERATURE].value, run.series[TEMPERATURE].value)


def test_the_commands_that_are_shown_prepare_the_same_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    state = opened(folder)
    asyncio.run(state.prepare("pulse.csv", RECIPE))
    (line,) = command_lines.prepare(state)
    file = state.paths("train")[0]
    made = file.read_bytes()
    file.unlink()
    monkeypatch.chdir(folder)
    assert line.startswith("lce prepare pulse.csv --recipe workbench/prepared/")
    assert lce(shlex.split(line)[1:]) == 0 and file.read_bytes() == made
    model = state.session.model_file(1)
    compare = command_lines.compare(state, model).replace("--report compare.html", "--json c.json")
    assert lce(shlex.split(compare)[1:]) == 0
    comparison = state.comparison()
    assert comparison is not None
    told = json.loads((folder / "c.json").read_text())
    shown = next(run for run in comparison.runs if run.run.name == "pulse")
    assert any(
        np.isclose(value, shown.channels[DISPLACEMENT].metrics.rms) for value in _numbers(told)
    )  # the page and the command count the same samples


def _numbers(content: object) -> list[float]:
    if isinstance(content, dict):
        return [number for value in content.values() for number in _numbers(value)]
    if isinstance(content, list):
        return [number for value in content for number in _numbers(value)]
    return [float(content)] if isinstance(content, int | float) else []


def test_a_step_that_makes_no_sense_changes_nothing(folder: Path) -> None:
    state = opened(folder)
    entry, version = state.entries["pulse.csv"], state.version
    with pytest.raises(LceError, match=r"^pulse: step 1, cut all sensors from 80 to 90 s: no sample lies there$"):
        asyncio.run(state.prepare("pulse.csv", (Cut(80.0, 90.0),)))
    assert state.entries["pulse.csv"] is entry and state.version == version and not state.undoing.to_undo.count("pulse")


def test_a_run_that_is_looked_at_again_draws_nothing_anew(folder: Path) -> None:
    state = opened(folder)
    version = state.version
    asyncio.run(state.read("pulse.csv"))
    assert state.version == version


def test_files_that_are_no_runs_by_themselves_become_one(folder: Path) -> None:
    state = opened(folder)
    assert "nothing to relate" in state.entries["camera.csv"].error
    asyncio.run(state.prepare("camera.csv", (Merge("laser.csv", 0.5),)))
    run = state.runs("train")["camera.csv"]
    assert set(run.series) == {POWER, TEMPERATURE} and run.series[TEMPERATURE].time_s[0] == -0.5
    assert folder / "laser.csv" in state.recordings()
    asyncio.run(state.remove_step("camera.csv", 0))
    assert "nothing to relate" in state.entries["camera.csv"].error and not state.session.recipes


def test_a_foreign_session_cannot_reach_out_of_its_folder(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in" / "pulse.csv").write_bytes((folder / "pulse.csv").read_bytes())
    state = opened(folder / "in")
    steps = [{"step": "merge", "file": "../camera.csv", "at_s": 50.0}]
    file = state.session.place / "session.yaml"
    file.write_text(yaml.safe_dump({**yaml.safe_load(file.read_text()), "recipes": {"pulse.csv": steps}}))
    again = opened(folder / "in")
    assert "../camera.csv: not in the folder" in again.entries["pulse.csv"].error
    file.write_text(file.read_text().replace("at_s: 50.0", "at_s: soon"))
    with pytest.raises(
        LceError, match=r"session\.yaml: recipe of pulse\.csv: \[0\]\.at_s is 'soon'; it must be a number"
    ):
        WorkbenchState(folder / "in")


def test_a_link_in_place_of_the_prepared_runs_is_not_followed(
    folder: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    state = opened(folder)
    state.session.prepared.symlink_to(tmp_path_factory.mktemp("elsewhere"))
    with pytest.raises(LceError, match="a link that leads out of the folder"):
        asyncio.run(state.prepare("pulse.csv", RECIPE))


def test_an_archive_holds_recordings_recipes_and_what_is_merged(folder: Path, tmp_path: Path) -> None:
    state = opened(folder)
    asyncio.run(state.prepare("camera.csv", (Merge("laser.csv"),)))
    archive.write(state.session, state.recordings(), tmp_path / "all.zip")
    with ZipFile(tmp_path / "all.zip") as found:
        assert {"camera.csv", "laser.csv", "pulse.csv", "workbench/session.yaml"} <= set(found.namelist())
    there = opened(archive.unpack(tmp_path / "all.zip"))
    assert set(there.runs("train")["camera.csv"].series) == {POWER, TEMPERATURE}


def test_prepared_runs_that_nothing_names_are_removed_at_the_next_start(folder: Path) -> None:
    state = opened(folder)
    for recipe in ((Cut(8.0, 9.0),), (Cut(8.0, 9.5),), (Cut(8.0, 9.9),)):
        asyncio.run(state.prepare("pulse.csv", recipe))
    first = state.session.prepared_file("pulse.csv", folder / "pulse.csv", (Cut(8.0, 9.0),))
    state._add_to_history("fitted", None, f"lce fit {first.relative_to(folder)} --out model.yaml")
    (state.session.prepared / "mine").mkdir()
    assert len(list(state.session.prepared.iterdir())) == 4
    again = WorkbenchState(folder)
    again.session = again.session.with_current(1)
    asyncio.run(again.open())
    last = again.entries["pulse.csv"].file
    assert {path.name for path in again.session.prepared.iterdir()} == {"mine", first.parent.name, last.parent.name}


def test_decisions_are_taken_back_and_taken_again_and_no_model_is_lost(folder: Path) -> None:
    state = opened(folder)
    state.keep(STRIP, "creep added")
    state.set_role("stairs.csv", "test")
    asyncio.run(state.prepare("pulse.csv", RECIPE))
    assert state.undoing.to_undo == "the preparation of pulse.csv"
    asyncio.run(state.undo())
    assert state.runs("train")["pulse.csv"].series[POWER].time_s.size == TIME.size and not state.session.recipes
    asyncio.run(state.undo())
    assert state.session.roles["stairs.csv"] == "train"
    asyncio.run(state.undo())
    assert (state.session.current, len(state.session.models)) == (1, 2)
    for _ in range(3):
        asyncio.run(state.redo())
    assert (state.session.current, state.session.roles["stairs.csv"]) == (2, "test")
    assert state.runs("train")["pulse.csv"].series[POWER].time_s.size < 500
    with pytest.raises(LceError, match="nothing to do again"):
        asyncio.run(state.redo())
    asyncio.run(state.undo())
    state.choose(1)
    assert state.undoing.to_redo == ""
    assert run_figures(state, "pulse.csv")
    assert WorkbenchState(folder).session.current == 1


def test_the_figures_show_every_sample_before_and_after(folder: Path) -> None:
    state = opened(folder)
    asyncio.run(state.prepare("pulse.csv", RECIPE))
    entry = state.entries["pulse.csv"]
    assert entry.recording is not None and entry.run is not None
    power, temperature, displacement = drawings.preparation(entry.recording, entry.run)
    for figure in (power, temperature, displacement):
        assert isinstance(figure, Lines) and [curve.label for curve in figure.curves] == ["as recorded", "prepared"]
    assert isinstance(displacement, Lines)
    shown = [int(np.isfinite(curve.y).sum()) for curve in displacement.curves]
    assert shown == [TIME.size, entry.run.series[DISPLACEMENT].time_s.size]


def test_the_tab_prepares_a_run_by_fields_and_buttons(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        def field(mark: str) -> ui.number:
            (found,) = user.find(marker=mark).elements
            assert isinstance(found, ui.number)
            return found

        await user.should_see("None: the run is used as it was recorded.", retries=100)
        (chosen,) = user.find(marker="prepared").elements
        assert isinstance(chosen, ui.select)
        chosen.set_value("pulse.csv")
        user.find(marker="cut").click()
        await user.should_see("From [s]: a number is needed", retries=100)
        field("begin").set_value(12.0)
        field("end").set_value(14.0)
        user.find(marker="cut").click()
        await user.should_see("cut all sensors from 12 to 14 s", retries=100)
        field("begin").set_value(0.0)
        field("end").set_value(0.9)
        user.find(marker="rest").click()
        field("level").set_value(0.0)
        user.find(marker="detrend").click()
        await user.should_see("take a straight line off displacement, fitted at rest: 0 to 0.9 s, to 0 m", retries=100)
        await user.should_see("the line is drawn far beyond the intervals at rest", retries=100)
        assert state.session.recipe("pulse.csv")[1] == Detrend("displacement", "line", ((0.0, 0.9),), 0.0)
        user.find(marker="remove-step-1").click()
        await user.should_not_see("cut all sensors from 12 to 14 s", retries=100)
        user.find(marker="undo").click()
        await user.should_see("cut all sensors from 12 to 14 s", retries=100)
        user.find(marker="resample").click()
        await user.should_see("means over 0.1 s", retries=100)

    tell(folder, story, "Prepare")
