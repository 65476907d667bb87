# SPDX-License-Identifier: Apache-2.0
"""The button Discover of the workbench: what was found, its slider, the file that adds it, and whom the page trusts."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from nicegui.testing import User, user_simulation

from lce_app.workbench import figures, own_effects, tasks
from lce_app.workbench.jobs import warm_up
from lce_app.workbench.kept_blocks import KeptSection, as_plain, blocks_of, from_plain, kept
from lce_app.workbench.page import Page
from lce_app.workbench.records import read_diagnosis, read_discovery
from lce_app.workbench.server import load, tend
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.tabs.export import commands
from lce_data.errors import LceError
from lce_data.progress import silent
from lce_data.read_runs import read_runs
from lce_data.units import KELVIN
from lce_model import default_model, simulate, trust
from lce_model.trust import UntrustedEffect
from lce_report import (
    Axis,
    Bars,
    Block,
    Curve,
    Details,
    Grid,
    Group,
    Heat,
    Intervals,
    Lines,
    Loop,
    Section,
    Table,
    Trace,
)

pytestmark = pytest.mark.alone

Story = Callable[[User, WorkbenchState], Awaitable[None]]
PATIENCE = 900
"""Looks at the page, 0.1 s apart."""
HEATER = default_model("lumped", "none").set({"lumped.gain": 35.0, "lumped.tau": 9.4, "ambient.t_env": 297.0})
TIME_S = np.arange(0.0, 80.0, 0.1)
POWERS = {
    "pulse": np.where((TIME_S > 2.0) & (TIME_S < 30.0), 1.3, 0.0),
    "stairs": 0.3 * (TIME_S // 14.0) % 1.5,
    "holds": np.select([TIME_S < 25.0, TIME_S < 50.0], [1.2, 0.4], 0.9),
}
DIAGNOSIS = {
    "verdict": "unexplained",
    "sentences": ["Something is missing that no effect of the library is."],
    "added": [],
    "candidates": [],
    "tables": {
        "errors": {"title": "RMS error, × noise", "head": ["runs"], "rows": [["pulse"]]},
        "steps": None,
        "varies": None,
        "strengths": None,
        "ranking": None,
        "not_tried": "",
        "evidence": {"title": "", "head": ["effect"], "rows": []},
    },
    "leading": [],
}


def opened(folder: Path) -> WorkbenchState:
    """The page's state of a folder, its runs read."""
    state = WorkbenchState(folder)
    asyncio.run(state.open({"holds.csv": "test"}))
    return state


@pytest.fixture(scope="module")
def discovered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Runs of a heater that also loses heat by radiation, a model that does not, and what the task discovers of it."""
    folder = tmp_path_factory.mktemp("heater")
    strip = HEATER.set({"lumped.gain": 45.0, "lumped.tau": 12.0}).add("radiation")
    strip = strip.set({"radiation.emissivity": 0.9, "radiation.area_per_capacity": 8e-3})
    for seed, (name, power) in enumerate(POWERS.items()):
        seen = simulate(strip, TIME_S, power).temperature_k - KELVIN
        seen += 0.05 * np.random.default_rng(seed).standard_normal(TIME_S.size)
        rows = [f"{t:.2f},{p:.3f},{k:.4f}" for t, p, k in zip(TIME_S, power, seen, strict=True)]
        (folder / f"{name}.csv").write_text("\n".join(["time_s,power_w,temperature_c", *rows]) + "\n")
    state = WorkbenchState(folder)
    state.keep(HEATER, "by hand")
    session = opened(folder).session
    session.diagnosis_file(1).write_text(json.dumps(DIAGNOSIS))
    runs, test = [folder / "pulse.csv", folder / "stairs.csv"], [folder / "holds.csv"]
    out, effect_file = session.discovery_file(1), session.next_found_file(1)
    tasks.discover(runs, test, session.model_file(1), effect_file, out, progress=silent)
    return folder


@pytest.fixture
def folder(discovered: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    for file in discovered.rglob("*.*"):
        copy = tmp_path / file.relative_to(discovered)
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(file.read_bytes())
    return tmp_path


def tell(folder: Path, story: Story) -> None:
    """A story on the tab Diagnose of a folder, whose runs are read."""

    async def run() -> None:
        state = WorkbenchState(folder)
        async with user_simulation(lambda: Page(state, "Diagnose") and None) as user:
            await state.open()
            await load(state)
            await user.open("/")
            tending = asyncio.create_task(tend(state))
            await story(user, state)
            tending.cancel()

    asyncio.run(run())


def effect_of(folder: Path) -> str:
    """Name of the effect that was found."""
    (found,) = read_discovery(folder / "workbench" / "discovery-1.json").found
    return found.effect


def test_the_button_comes_after_unexplained_alone(folder: Path) -> None:
    (folder / "workbench" / "discovery-1.json").unlink()

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see(marker="discover")
        diagnosis = state.session.diagnosis_file(1)
        diagnosis.write_text(json.dumps({**DIAGNOSIS, "verdict": "adequate"}))
        state.version += 1
        await user.should_see("Adequate: no effect is missing")
        await user.should_not_see(marker="discover")

    tell(folder, story)


def test_an_answer_of_other_runs_than_those_in_use_says_so(folder: Path) -> None:
    state = opened(folder)
    names = {role: [run.name for run in state.runs(role).values()] for role in ("train", "test")}
    record = {**DIAGNOSIS, "runs": names["train"], "held_out": names["test"], "files": state.read_by_jobs()}
    (folder / "workbench" / "diagnosis-1.json").write_text(json.dumps(record))

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see("Unexplained: no effect of the library explains enough of what is left")
        await user.should_not_see(marker="other runs")
        state.set_role("stairs.csv", "off")
        await user.should_see(content="found from pulse, stairs; judged on holds. Diagnose again")

    tell(folder, story)


def test_a_run_has_the_name_that_a_job_gives_it(folder: Path) -> None:
    for file, place in (("pulse.csv", "runs/pulse.csv"), ("stairs.csv", "later/pulse.csv")):
        (folder / place).parent.mkdir()
        (folder / file).rename(folder / place)
    state = opened(folder)
    read = read_runs([*state.paths("train"), *state.paths("test")])
    assert {name: run.name for name, run in state.used().items()} == {
        "later/pulse.csv": "later/pulse",
        "runs/pulse.csv": "runs/pulse",
        "holds.csv": "holds",
    }
    assert [run.name for run in read] == [run.name for run in state.used().values()]
    state.set_role("later/pulse.csv", "off")
    assert [run.name for run in state.used().values()] == ["pulse", "holds"]


def test_a_link_to_a_run_does_not_keep_the_page_from_opening(folder: Path) -> None:
    (folder / "later").mkdir()
    for link in ("again.csv", "later/pulse.csv"):
        (folder / link).symlink_to(folder / "pulse.csv")
    used = opened(folder).used()
    assert [used[name].name for name in ("again.csv", "later/pulse.csv", "pulse.csv")] == ["again", "pulse", "pulse"]
    with pytest.raises(LceError, match="is given twice"):
        read_runs([folder / "again.csv", folder / "pulse.csv"])


def test_the_base_model_that_does_better_is_identified_by_a_click(folder: Path) -> None:
    warm_up()
    better = {"deformation": "none", "effects": ["radiation"], "varies": [], "added": ["radiation"]}
    (folder / "workbench" / "diagnosis-1.json").write_text(json.dumps({**DIAGNOSIS, "other_base": better}))

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see("Another base model does better")
        user.find("Fit none with radiation").click()
        await user.should_see("model 2: lumped + none + radiation fitted", retries=PATIENCE)
        model = state.model()
        assert model is not None and (model.thermal, model.effect_names) == ("lumped", ("radiation",))
        kept = state.session.kept(2)
        assert kept.how == "lumped + none + radiation fitted"
        assert kept.command.startswith("lce fit pulse.csv stairs.csv --thermal lumped --deformation none --effect rad")

    tell(folder, story)


def test_the_button_runs_a_job_whose_files_are_trusted(folder: Path) -> None:
    warm_up()
    before = read_discovery(folder / "workbench" / "discovery-1.json")

    (folder / "workbench" / "discovery-1.json").unlink()

    async def story(user: User, state: WorkbenchState) -> None:
        user.find(marker="discover").click()
        await user.should_see(marker="discovered", retries=PATIENCE)
        (found,) = read_discovery(state.session.discovery_file(1)).found
        assert (found.effect, found.sha256) == (before.found[0].effect, before.found[0].sha256)
        assert found.file == "found-1-2.py"  # a model may name the first one
        assert trust.is_trusted(found.sha256)
        await user.should_see(marker=f"slider {found.effect}.c")
        user.find(marker=f"slider {found.effect}.c").trigger("move", 100)
        await user.should_see(marker=f"add {found.effect}")

    tell(folder, story)


def test_a_file_of_another_session_is_shown_and_run_only_when_trusted(folder: Path) -> None:
    effect = effect_of(folder)

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see("Found: a function that no effect of the library is")
        await user.should_see(marker="effect file")
        await user.should_not_see(marker=f"add {effect}")
        user.find(marker="trust").click()
        await user.should_see(marker=f"add {effect}")

    tell(folder, story)


def test_opening_the_page_runs_no_file(folder: Path) -> None:
    file = folder / "workbench" / "found-1.py"
    file.write_text(f"{file.read_text()}\nopen({str(folder / 'was_run')!r}, 'w').close()\n")

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see(marker="trust")
        with pytest.raises(UntrustedEffect, match=r"found-1\.py: not run, because you have not trusted it"):
            own_effects.add(state, file)

    tell(folder, story)
    assert not (folder / "was_run").exists()


def test_opening_the_page_runs_no_file_that_a_model_or_a_record_names(folder: Path) -> None:
    (folder / "evil.py").write_text(f"open({str(folder / 'was_run')!r}, 'w').close()\n")
    model = folder / "workbench" / "model-1.yaml"
    model.write_text(model.read_text().replace("effects: []", f"effects: [{folder / 'evil.py'}]"))
    candidate = {"effect": str(folder / "evil.py"), "meaning": "", "standing": "not tried", "reason": "", "shown": True}
    candidate |= {"evidence": 0.0, "p_value": 0.0, "visibility": 0.0, "aliases": [], "settings": {}}
    diagnosis = folder / "workbench" / "diagnosis-1.json"
    diagnosis.write_text(json.dumps({**DIAGNOSIS, "candidates": [candidate]}))
    with pytest.raises(LceError, match=r"evil\.py' is no effect of the library"):
        read_diagnosis(diagnosis)

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see("is no effect of the library")
        user.find("Add").click()
        await user.should_see("evil.py is a program that was not run")

    tell(folder, story)
    assert not (folder / "was_run").exists()


def test_a_trusted_file_that_changes_is_trusted_no_longer(folder: Path) -> None:
    file = folder / "workbench" / "found-1.py"
    trust.trust(file)
    assert own_effects.effect_of(file).name == effect_of(folder)
    file.write_text(f"{file.read_text()}\n")
    with pytest.raises(UntrustedEffect):
        own_effects.effect_of(file)


def test_what_was_found_is_added_as_the_command_does(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    effect, asked = effect_of(folder), dict[str, object]()
    monkeypatch.setattr(WorkbenchState, "start_model", lambda self, *words, **more: asked.update(more, words=words))

    async def story(user: User, state: WorkbenchState) -> None:
        trust.trust(folder / "workbench" / "found-1.py")
        state.version += 1
        await user.should_see(marker=f"add {effect}")
        user.find(marker=f"add {effect}").click()
        await user.should_see("Fit a model")

    tell(folder, story)
    assert asked["effect"] == str(folder / "workbench" / "found-1.py")
    words = asked["words"]
    assert isinstance(words, tuple) and words[-1] == (
        "lce add ./workbench/found-1.py pulse.csv stairs.csv --test holds.csv --model workbench/model-1.yaml "
        "--out model.yaml"
    )
    exported = commands(opened(folder))
    assert any(line.startswith("lce discover pulse.csv stairs.csv --test holds.csv") for line in exported)


def test_the_page_shows_the_sections_of_the_report(folder: Path) -> None:
    record = read_discovery(folder / "workbench" / "discovery-1.json")
    report = (folder / "workbench" / "discovery-1.html").read_text()
    for section in record.sections:
        assert f"<h2>{section.heading}</h2>" in report
        key = "test"
        figures._shown[key] = partial(blocks_of, section)
        assert figures.packed(key) is not None
        del figures._shown[key]


def test_blocks_are_read_as_they_were_kept() -> None:
    x, y = np.arange(3.0), np.array([1.0, np.nan, 2.0])
    lines = Lines("l", Axis("t", "s"), Axis("T", "K"), x, [Curve("c", y, "model", low=y - 1.0, high=y + 1.0)])
    table = Table("t", ["a"], [["1"]])
    blocks: list[Block] = [
        "a paragraph",
        lines,
        Loop("o", Axis("t", "s"), Axis("T", "K"), [Trace("t", x, y, "model")]),
        Heat("h", "", ["a", "b", "c"], ["r"], y[None], framed=[(0, 1)]),
        Bars("b", "1", ["a", "b", "c"], [Group("g", "model", y)]),
        Intervals("i", "1", ["a", "b", "c"], y, y, ["", "", ""], 0.0),
        table,
        Details("d", ["text", table]),
        Grid([lines, (lines, table)], (3, 2)),
    ]
    plain = json.loads(json.dumps(as_plain(kept(Section("s", blocks))), allow_nan=False))
    read = blocks_of(from_plain(plain, KeptSection))
    assert [type(block) for block in read] == [type(block) for block in blocks]
    again = json.dumps(as_plain(kept(Section("s", read))))
    assert json.loads(again) == plain
    assert isinstance(read[1], Lines) and np.array_equal(read[1].curves[0].y, y, equal_nan=True)


@pytest.mark.parametrize("content", [{}, [], {"heading": "s", "blocks": [{"lines": {"title": "l"}}]}])
def test_what_is_no_section_is_refused(content: object) -> None:
    with pytest.raises(LceError, match="not what the workbench wrote"):
        from_plain(content, KeptSection)
