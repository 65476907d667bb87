# SPDX-License-Identifier: Apache-2.0
"""The page of `lce workbench` as a user meets it, without a browser."""

import asyncio
import json
import socket
import struct
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jobs_for_tests import counting, crashing, endless, refusing
from nicegui import ui
from nicegui.testing import User, user_simulation

from lce_app.cli.main import main as lce
from lce_app.workbench import drawings, figures, session
from lce_app.workbench.bench import Workbench
from lce_app.workbench.by_hand import LABEL, ByHand
from lce_app.workbench.guard import Guard
from lce_app.workbench.jobs import Job, warm_up
from lce_app.workbench.page import Page
from lce_app.workbench.server import load, tend
from lce_app.workbench.tabs.compare import lit, run_figures, shares
from lce_app.workbench.tabs.export import commands
from lce_data.errors import LceError
from lce_data.units import KELVIN
from lce_model import default_model, simulate
from lce_report import Grid, Lines, Loop
from lce_report.run_section import NAMES, VALUE, Colouring, run_section

pytestmark = pytest.mark.alone

STRIP = default_model().add("creep").set({"creep.share": 0.15, "creep.tau_v": 8.0})
Story = Callable[[User, Workbench], Awaitable[None]]


def record(path: Path, power: np.ndarray, seed: int) -> None:
    """A CSV of a strip that creeps: camera at 10 Hz, distance at 100 Hz."""
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


@pytest.fixture(scope="session")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two runs, a third in a folder below, and a file that is none."""
    folder = tmp_path_factory.mktemp("campaign")
    (folder / "later").mkdir()
    time = np.arange(0.0, 40.0, 0.01)
    record(folder / "pulse.csv", np.where((time > 1.0) & (time < 16.0), 2.3, 0.0), 1)
    record(folder / "stairs.csv", np.select([time < 10.0, time < 18.0, time < 26.0], [1.0, 2.2, 1.2], 0.0), 2)
    record(folder / "later" / "other.csv", np.select([time < 7.0, time < 14.0, time < 24.0], [2.4, 0.5, 2.0], 0.0), 3)
    (folder / "junk.csv").write_text("time_s,volts\n0,1\n")
    return folder


@pytest.fixture(scope="session", autouse=True)
def libraries() -> None:
    """The process that jobs are forked from, with what they import."""
    warm_up()


@pytest.fixture
def folder(campaign: Path, tmp_path: Path) -> Path:
    """A copy of the campaign."""
    for file in campaign.rglob("*.csv"):
        copy = tmp_path / file.relative_to(campaign)
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(file.read_bytes())
    return tmp_path


def told(folder: Path, story: Story, tab: str = "Runs") -> None:
    """A story on the page of a folder, whose runs are read."""

    @asynccontextmanager
    async def opened() -> AsyncIterator[tuple[User, Workbench]]:
        bench = Workbench(folder)
        async with user_simulation(lambda: Page(bench, tab) and None) as user:
            await load(bench)
            await user.open("/")
            tending = asyncio.create_task(tend(bench))
            yield user, bench
            tending.cancel()

    async def run() -> None:
        async with opened() as (user, bench):
            await story(user, bench)

    asyncio.run(run())


def with_model(folder: Path) -> Workbench:
    """The runs read, one held out, and a model of them that does not creep."""
    bench = Workbench(folder)
    bench.keep(STRIP.without("creep"), "by hand")
    asyncio.run(bench.open({"later/other.csv": "test"}))
    return bench


def test_runs_are_listed_and_what_is_none_says_why(folder: Path) -> None:
    async def story(user: User, bench: Workbench) -> None:
        for name in ("pulse.csv", "stairs.csv", "later/other.csv"):
            await user.should_see(name)
        await user.should_see("cannot be used: junk.csv: header 'time_s,volts'; expected time_s and of")
        assert set(bench.runs("train")) == {"pulse.csv", "stairs.csv", "later/other.csv"}

    told(folder, story)


def test_the_use_of_a_run_is_remembered_beside_the_runs(folder: Path) -> None:
    bench = with_model(folder)
    again = Workbench(folder)
    assert again.session.roles["later/other.csv"] == "test"
    assert again.session.current == 1 and again.session.models == bench.session.models
    assert again.model() == bench.model()


def test_a_session_file_that_is_none_is_told_and_left_alone(folder: Path) -> None:
    file = folder / "workbench" / "session.yaml"
    file.parent.mkdir()
    file.write_text("format: something else\n")
    with pytest.raises(LceError, match=r"session\.yaml: no session of the workbench"):
        Workbench(folder)
    assert file.read_text() == "format: something else\n"


def test_nothing_outside_of_the_folder_is_found(folder: Path) -> None:
    inside = folder / "later"
    (inside / "out.csv").symlink_to(folder / "pulse.csv")
    (inside / "up").symlink_to(folder)
    assert set(session.find_runs(inside)) == {"other.csv"}


def test_undo_goes_back_to_where_a_model_came_from(folder: Path) -> None:
    bench = with_model(folder)
    bench.keep(STRIP, "creep added")
    assert bench.session.current == 2
    bench.undo()
    assert bench.session.current == 1
    bench.keep(STRIP, "something else")
    assert (bench.session.current, bench.session.kept(3).parent) == (3, 1)
    bench.undo()
    with pytest.raises(LceError, match="nothing to undo"):
        bench.undo()
    assert [kept.number for kept in bench.session.models] == [1, 2, 3]


def test_the_look_is_what_the_report_draws_with_every_sample(folder: Path) -> None:
    bench = with_model(folder)
    drawn = "".join(str(block) for block in shares(bench))
    assert "of the squared error of d" in drawn
    key = "test"
    figures._shown[key] = lambda: run_figures(bench, "pulse.csv")
    block = figures.packed(key)
    del figures._shown[key]
    assert block is not None
    (length,) = struct.unpack("<I", block[:4])
    page = json.loads(block[4 : 4 + length])
    titles = [figure["title"] for figure in page["figures"]]
    assert "hysteresis loop: d over T" in titles and "laser power P" in titles
    run = bench.entries["pulse.csv"].run
    assert run is not None and run.displacement is not None
    displacement = page["figures"][titles.index("displacement\u00a0d")]
    begin, n = displacement["curves"][0]["y"]
    numbers = np.frombuffer(block[4 + length :], "<f4")
    assert numbers[begin : begin + n] == pytest.approx(1e3 * run.displacement.value, rel=1e-6)


def test_a_cell_of_the_shares_lights_its_samples_up(folder: Path) -> None:
    comparison = with_model(folder).comparison()
    assert comparison is not None
    quarters = comparison.shares["displacement"].regimes
    ramp = [share for share in quarters if share.branch == "cooling" and not share.held]
    found = lit(comparison, "displacement regime", 2, 1)
    seconds = sum(to - since for spans in found.values() for since, to in spans)
    total = sum(run.run.displacement.time_s[-1] for run in comparison.runs if run.run.displacement is not None)
    assert seconds / total == pytest.approx(ramp[1].sample_share, abs=0.01)
    assert set(lit(comparison, "displacement cycle", 0, 0)) == {"pulse", "stairs", "later/other"}
    assert not any(lit(comparison, "", 0, 0).values())


def test_look_without_a_model_says_what_to_do(folder: Path) -> None:
    async def story(user: User, bench: Workbench) -> None:
        await user.should_see("A model and a run are needed")
        bench.keep(STRIP, "by hand")
        await user.should_see(marker="shares")

    told(folder, story, "Look")


@pytest.mark.parametrize(
    ("token", "headers", "query", "status"),
    [
        ("", {"host": "127.0.0.1:8080"}, "", 200),
        ("", {"host": "[::1]:8080"}, "", 200),
        ("", {"host": "rebound.example:8080"}, "", 403),
        ("", {"host": "localhost:8080", "origin": "http://localhost:8080"}, "", 200),
        ("", {"host": "localhost:8080", "origin": "http://other.example"}, "", 403),
        ("", {"host": "localhost:8080", "origin": "null"}, "", 403),
        ("secret", {"host": "bench.lab:8080"}, "", 403),
        ("secret", {"host": "localhost:8080"}, "", 403),
        ("secret", {"host": "bench.lab:8080"}, "token=guess", 403),
        ("secret", {"host": "bench.lab:8080"}, "token=secret", 200),
        ("secret", {"host": "bench.lab:8080", "cookie": "lce_workbench=secret"}, "", 200),
        ("secret", {"host": "bench.lab:8080", "cookie": "lce_workbench=other"}, "", 403),
    ],
)
def test_who_is_answered(token: str, headers: dict[str, str], query: str, status: int) -> None:
    sent: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def receive() -> dict[str, Any]:
        return {}

    async def send(message: dict[str, Any]) -> None:
        sent.append(message)

    coded = [(key.encode(), value.encode()) for key, value in headers.items()]
    for kind in ("http", "websocket"):
        sent.clear()
        scope = {"type": kind, "headers": coded, "query_string": query.encode()}
        asyncio.run(Guard(app, token)(scope, receive, send))
        refused = sent[0]["type"] == "websocket.close" or sent[0]["status"] == 403
        assert refused == (status == 403)
        told = dict(sent[0].get("headers", []))
        assert (b"set-cookie" in told) == ("token=secret" in query)
        assert refused or b"default-src 'self'" in told[b"content-security-policy"]


def ended(bench: Workbench, timeout_s: float = 60.0) -> Job:
    """The job of the workbench, when it is over."""
    assert bench.job is not None
    bench.job.wait(timeout_s)
    bench.poll()
    assert not bench.working
    return bench.job


def test_a_job_tells_where_it_is_and_what_follows_is_done(folder: Path) -> None:
    bench, followed = Workbench(folder), []
    bench.start("Count", counting, lambda: followed.append(True), out=folder / "counted")
    with pytest.raises(LceError, match="Count is under way"):
        bench.start("Count", counting, out=folder / "again")
    job = ended(bench)
    assert job.state == "done" and followed == [True] and (folder / "counted").exists()
    assert job.seen[0].label == "starting"
    assert job.seen[0].seconds < 5.0


def test_what_a_job_finds_wanting_is_one_line(folder: Path) -> None:
    bench = Workbench(folder)
    bench.start("Refuse", refusing)
    assert (ended(bench).state, bench.job and bench.job.error) == ("failed", "no run")


def test_a_crashed_job_costs_neither_page_nor_history(folder: Path) -> None:
    bench = with_model(folder)
    bench.start_model("Crash", crashing, "never", 1)
    job = ended(bench)
    assert job.state == "failed" and "its process ended" in job.error
    assert [kept.number for kept in bench.session.models] == [1]
    bench.start("Count", counting, out=folder / "counted")
    assert ended(bench).state == "done"


def test_a_job_is_cancelled(folder: Path) -> None:
    async def story(user: User, bench: Workbench) -> None:
        bench.start("Wait", endless, out=folder / "never")
        await user.should_see("Wait: ", retries=50)
        user.find("Cancel").click()
        await user.should_see("Wait was cancelled")
        assert bench.job is not None and bench.job.state == "cancelled"

    told(folder, story)


def test_the_history_says_how_the_error_fell_and_which_commands_do_the_same(folder: Path) -> None:
    bench = with_model(folder)
    bench.keep(STRIP, "creep added to model 1")
    (sides,) = drawings.history(bench)
    assert isinstance(sides, Grid)
    displacement = sides.figures[1]
    assert isinstance(displacement, Lines) and len(displacement.curves) == 2
    assert all(curve.y[1] < 0.5 * curve.y[0] for curve in displacement.curves)
    model = "--model workbench/model-2.yaml --report"
    assert commands(bench) == [
        f"lce compare pulse.csv stairs.csv later/other.csv {model} compare.html",
        f"lce diagnose pulse.csv stairs.csv --test later/other.csv {model} diagnose.html",
    ]


def test_a_file_that_cannot_be_read_costs_only_what_needs_it(folder: Path) -> None:
    bench = with_model(folder)
    bench.keep(STRIP, "by hand")
    bench.session.model_file(1).write_text("format: something else\n")
    bench.session.diagnosis_file(2).write_text("{}")

    async def story(user: User, bench: Workbench) -> None:
        await user.should_see(content="model-1.yaml")
        user.find("Learn").click()
        await user.should_see(content="diagnosis-2.json: not what the workbench wrote")
        user.find("Runs").click()
        await user.should_see("pulse.csv")

    told(folder, story, "Add")


def test_curves_follow_a_slider_and_what_they_show_can_be_kept(folder: Path) -> None:
    with_model(folder)
    model = Workbench(folder).model()
    assert model is not None

    async def story(user: User, bench: Workbench) -> None:
        before = model["lumped.gain"]
        user.find(marker="slider lumped.tau").trigger("move", 900)
        user.find(marker="back").click()
        user.find(marker="slider lumped.gain").trigger("move", 900)
        user.find(marker="keep").click()
        await user.should_see("model 2: by hand")
        moved = bench.model()
        assert moved is not None and moved["lumped.gain"] > before
        assert moved["lumped.tau"] == model["lumped.tau"]

    told(folder, story, "Add")


def test_curves_by_hand_are_what_the_model_says(folder: Path) -> None:
    bench = with_model(folder)
    model, comparison = bench.model(), bench.comparison()
    assert model is not None and comparison is not None
    run = bench.runs("train")["pulse.csv"]
    for stage in next(found for found in comparison.runs if found.run is run).stages:
        curve = ByHand.of(model, run).curves(model)[f"{NAMES[stage.quantity]}/{LABEL}"]
        assert curve == pytest.approx(stage.modelled * VALUE[stage.quantity][1])


def test_the_loop_is_coloured_by_branch_or_cycle(folder: Path) -> None:
    comparison = with_model(folder).comparison()
    assert comparison is not None
    (other,) = [run for run in comparison.runs if run.run.name == "later/other"]
    stage = other.stage("displacement")
    assert stage is not None
    wanted: dict[Colouring, list[str]] = {"branch": ["heating", "cooling"], "cycle": ["cycle 1", "cycle 2"]}
    for by, parts in wanted.items():
        (loop,) = [
            figure
            for grid in run_section(other, by).blocks
            if isinstance(grid, Grid)
            for cell in grid.figures
            for figure in (cell if isinstance(cell, tuple) else (cell,))
            if isinstance(figure, Loop) and "loop" in figure.title
        ]
        assert [trace.label for trace in loop.traces] == [*parts, "model"]
        seen = np.array([np.isfinite(trace.y) for trace in loop.traces[:-1]])
        assert (seen.sum(axis=0) == 1).all()


def test_two_runs_of_one_name_stay_two(folder: Path) -> None:
    (folder / "pulse.csv").rename(folder / "other.csv")
    comparison = with_model(folder).comparison()
    assert comparison is not None
    assert set(comparison.shares["displacement"].runs) == {"other", "stairs", "later/other"}


@pytest.mark.parametrize("protocol", ["../outside.csv", "/etc/hostname", "waves", "pulse.csv/../../outside.csv"])
def test_a_wave_from_outside_of_the_folder_is_refused(folder: Path, protocol: str) -> None:
    (folder.parent / "outside.csv").write_text("time_s,power_w\n0,1\n1,0\n")

    async def story(user: User, bench: Workbench) -> None:
        (entry,) = user.find(kind=ui.input, marker="protocol").elements
        entry.value = protocol
        user.find(marker="start").click()
        await user.should_see(f"{protocol}: neither a protocol nor a CSV file in this folder")
        assert bench.job is None

    told(folder, story, "Bench")


def test_a_folder_that_cannot_be_served_is_told_in_one_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "workbench").write_text("in the way")
    assert lce(["workbench", str(folder)]) == 1
    assert lce(["workbench", str(folder / "none")]) == 1
    assert lce(["workbench", str(folder), "--model", str(folder / "none.yaml")]) == 1
    (folder / "workbench").unlink()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        assert lce(["workbench", str(folder), "--port", str(taken.getsockname()[1])]) == 1
    cannot, nowhere, no_model, busy = capsys.readouterr().err.splitlines()
    assert "workbench: cannot be made" in cannot
    assert "none: no such file or folder" in nowhere
    assert "none.yaml: no such file or folder" in no_model
    assert "--port and --host choose another" in busy
