# SPDX-License-Identifier: Apache-2.0
"""The tab of the workbench that makes a run of a foreign table, without a browser."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import numpy as np
import pytest
from nicegui import ui
from nicegui.elements.upload_files import SmallFileUpload
from nicegui.testing import User, user_simulation

from lce_app.workbench import own_effects
from lce_app.workbench.page import Page
from lce_app.workbench.server import load, tend
from lce_app.workbench.state import WorkbenchState
from lce_data.read_runs import read_run
from lce_model import default_model, save_model

pytestmark = pytest.mark.alone

Story = Callable[[User, WorkbenchState], Awaitable[None]]
PATIENCE = 100
"""Looks at the page, 0.1 s apart."""
TIME_S = np.arange(0.0, 60.0, 0.5)
POWER_MW = np.where(TIME_S < 30.0, 500.0, 0.0)
WARM_C = 22.0 + 30.0 * np.where(TIME_S < 30.0, 1.0 - np.exp(-TIME_S / 8.0), np.exp(-(TIME_S - 30.0) / 8.0))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with one table, which is no run."""
    rows = [f"{t};{p};{k};{-1e-2 * (k - 22.0)}" for t, p, k in zip(TIME_S, POWER_MW, WARM_C, strict=True)]
    text = "\n".join(["Time;P;T1;d_mm", *rows]).replace(".", ",")
    (tmp_path / "day1.csv").write_text(text, encoding="utf-8")
    return tmp_path


def tell(folder: Path, story: Story) -> None:
    """A story on the tab Import of a folder, whose files are read."""

    async def run() -> None:
        state = WorkbenchState(folder)
        async with user_simulation(lambda: Page(state, "Import") and None) as user:
            await state.open()
            await load(state)
            await user.open("/")
            tending = asyncio.create_task(tend(state))
            await story(user, state)
            tending.cancel()

    asyncio.run(run())


def selected(user: User, marker: str) -> ui.select:
    (element,) = user.find(marker=marker).elements
    assert isinstance(element, ui.select)
    return element


def test_a_foreign_file_is_understood_corrected_and_imported(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        selected(user, "foreign file").set_value(str(folder / "day1.csv"))
        await user.should_see(marker="unit d_mm", retries=PATIENCE)
        await user.should_see("column and unit")
        assert selected(user, "quantity T1").value == "temperature" and selected(user, "unit P").value == "mW"
        selected(user, "unit d_mm").set_value("-mm")
        await user.should_not_see("column and unit", retries=PATIENCE)  # now all is said by hand
        user.find(marker="import").click()
        await user.should_see("runs/day1.csv", retries=PATIENCE)
        run = read_run(folder / "runs" / "day1.csv")
        assert run.power is not None and run.power.value.max() == pytest.approx(0.5)
        assert run.displacement is not None and run.displacement.value.max() == pytest.approx(3e-4, rel=0.05)
        assert state.session.roles["runs/day1.csv"] == "train"

    tell(folder, story)


def test_a_choice_that_leaves_no_run_is_told_and_taken_back(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        selected(user, "foreign file").set_value(str(folder / "day1.csv"))
        await user.should_see(marker="quantity Time", retries=PATIENCE)
        selected(user, "quantity Time").set_value("left out")
        await user.should_see("no column looks like a time", retries=PATIENCE)
        assert selected(user, "quantity Time").value == "time"

    tell(folder, story)


def test_of_a_file_that_is_not_understood_nothing_of_the_one_before_is_left(folder: Path) -> None:
    (folder / "words.csv").write_text("these are words\nand no table\n", encoding="utf-8")

    async def story(user: User, state: WorkbenchState) -> None:
        selected(user, "foreign file").set_value(str(folder / "day1.csv"))
        await user.should_see(marker="unit d_mm", retries=PATIENCE)
        selected(user, "foreign file").set_value(str(folder / "words.csv"))
        await user.should_see("no table of numbers", retries=PATIENCE)
        await user.should_not_see(marker="unit d_mm")
        (button,) = user.find(marker="import").elements
        assert isinstance(button, ui.button) and not button.enabled

    tell(folder, story)


EFFECT = """
from lce_model.effects import Effect, Parameter

raise SystemExit("this file was run")
"""


def test_files_that_are_dropped_go_where_they_belong_and_no_program_runs(folder: Path, tmp_path: Path) -> None:
    run = "time_s,power_w,temperature_c\n" + "".join(f"{t / 10},1.0,{25.0 + t}\n" for t in range(50))
    model = tmp_path / "elsewhere.yaml"
    save_model(default_model(), model)
    files = {"run.csv": run.encode(), "mine.yaml": model.read_bytes(), "mine.py": EFFECT.encode(), "odd.exe": b"MZ"}

    async def story(user: User, state: WorkbenchState) -> None:
        (upload,) = user.find(marker="upload").elements
        assert isinstance(upload, ui.upload)

        async def drop(name: str, content: bytes) -> None:
            await upload.handle_uploads([SmallFileUpload(name, "", content)])

        for name, content in files.items():
            await drop(name, content)
        await user.should_see("odd.exe: neither a run", retries=PATIENCE)
        await user.should_see("model 1: from mine.yaml", retries=PATIENCE)
        for _ in range(PATIENCE):
            if "runs/run.csv" in state.runs("train"):
                break
            await asyncio.sleep(0.1)
        assert "runs/run.csv" in state.runs("train")
        user.find("Add", kind=ui.tab).click()
        await user.should_see(marker="trust", retries=PATIENCE)
        await drop("mine.py", b"another")
        await user.should_see("mine.py: there is an effect file of that name", retries=PATIENCE)
        (file,) = own_effects.files(state)
        assert file.read_bytes() == EFFECT.encode()

    tell(folder, story)
