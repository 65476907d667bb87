# SPDX-License-Identifier: Apache-2.0
"""The tab Bench as a user meets it, without a browser: what is refused, what is kept, and what it never does."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from jobs_for_tests import endless
from nicegui import ui
from nicegui.testing import User, user_simulation

from lce_app.workbench.jobs import warm_up
from lce_app.workbench.live_layout import LiveView
from lce_app.workbench.page import Page
from lce_app.workbench.server import load, tend
from lce_app.workbench.state import WorkbenchState

Story = Callable[[User, WorkbenchState], Awaitable[None]]
PATIENCE = 100
"""Looks at the page, 0.1 s apart."""


@pytest.fixture(scope="module", autouse=True)
def libraries() -> None:
    """The process that jobs are forked from."""
    warm_up()


def tell(folder: Path, story: Story) -> None:
    """A story on the tab Bench of the page of a folder."""

    async def told() -> None:
        state = WorkbenchState(folder)
        async with user_simulation(lambda: Page(state, "Bench") and None) as user:
            await state.open()
            await load(state)
            await user.open("/")
            await user.should_see(marker="record", retries=PATIENCE)
            tending = asyncio.create_task(tend(state))
            await story(user, state)
            tending.cancel()
            state.close()

    asyncio.run(told())


def fill(user: User, marker: str, text: str) -> None:
    """Type into a field."""
    (field,) = user.find(marker=marker).elements
    assert isinstance(field, ui.input | ui.textarea)
    field.set_value(text)


def test_a_condition_that_cannot_be_starts_nothing(tmp_path: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        for marker, text, said in (
            ("ambient", "-300", "ambient_c is -300 °C, below absolute zero"),
            ("load", "heavy", "load_n is 'heavy'; it must be a number"),
            ("strip length", "0", "strip_length_m is 0.0; it must be a number > 0.0"),
            ("specimen", "x" * 201, "specimen has 201 characters; 200 are the most"),
        ):
            fill(user, marker, text)
            user.find(marker="start").click()
            await user.should_see(said, retries=PATIENCE)
            fill(user, marker, "")
        assert state.job is None and not (tmp_path / "workbench" / "bench.yaml").exists()

    tell(tmp_path, story)


def test_there_must_be_something_to_record_and_to_mark(tmp_path: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        user.find(marker="record").click()
        await user.should_see(
            "no topic of a bench is heard; start the workbench with the ROS_DOMAIN_ID", retries=PATIENCE
        )
        fill(user, "marker", "lamp on")
        user.find(marker="mark").click()
        await user.should_see("nothing runs that could be marked", retries=PATIENCE)
        assert state.job is None

    tell(tmp_path, story)


def test_to_stop_says_that_a_recording_of_others_has_no_laser(tmp_path: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        state.record("Record", endless, tmp_path / "theirs", only_listens=True)
        assert state.job is not None
        await user.should_see("Stop recording", retries=PATIENCE)
        user.find(marker="stop").click()
        await user.should_see("stop the laser where the run was started", retries=PATIENCE)
        assert state.working
        user.find(marker="record").click()
        await user.should_see("Record what runs now", retries=PATIENCE)
        assert state.job.state == "cancelled"

    tell(tmp_path, story)


def test_plots_are_changed_by_their_tools_and_watched_while_a_page_is_open(tmp_path: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        first, second, third = (plot.name for plot in state.live.layout.plots)
        assert state.live.watched == state.live.layout.series
        user.find(marker=f"plot {first}")
        for tool in ("move down", "higher", "wide or half as wide"):
            user.find(f"{tool}: {first}").click()
        user.find(f"remove: {third}").click()
        await user.should_not_see(marker=f"plot {third}", retries=PATIENCE)
        assert [plot.name for plot in state.live.layout.plots] == [second, first]
        assert (state.live.layout.plots[1].height, state.live.layout.plots[1].wide) == (240, True)
        assert LiveView(tmp_path).layout.series == state.live.layout.series
        assert user.client is not None
        user.client.delete()
        assert state.live.watched == frozenset()

    tell(tmp_path, story)


def test_a_layout_that_cannot_be_read_is_told_once(tmp_path: Path) -> None:
    (tmp_path / "workbench").mkdir()
    (tmp_path / "workbench" / "bench.yaml").write_text("format: other\n")

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see("the plots are the usual ones", retries=PATIENCE)
        await user.should_see(marker=f"plot {state.live.layout.plots[0].name}", retries=PATIENCE)

    tell(tmp_path, story)
