# SPDX-License-Identifier: Apache-2.0
"""The page of `lce workbench` as a user meets it, without a browser."""

import asyncio
import json
import re
import socket
import struct
import subprocess
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jobs_for_tests import counting, crashing, endless, refusing, warning
from nicegui import ui
from nicegui.testing import User, user_simulation
from starlette.applications import Starlette
from starlette.routing import Mount

from lce_app.cli.main import main as lce
from lce_app.use_cases import fit
from lce_app.use_cases.fit import ModelChoice
from lce_app.workbench import drawings, figures, session, tasks
from lce_app.workbench.by_hand import LABEL, ByHand
from lce_app.workbench.guard import protect
from lce_app.workbench.jobs import Job, warm_up
from lce_app.workbench.page import TABS, Page
from lce_app.workbench.server import load, tend
from lce_app.workbench.state import WorkbenchState
from lce_app.workbench.tabs.compare import models_over_run, picked_samples, run_figures, shares
from lce_app.workbench.tabs.export import commands
from lce_data.channels import DISPLACEMENT
from lce_data.errors import LceError
from lce_data.progress import Progress, silent
from lce_data.units import KELVIN
from lce_model import default_model, simulate
from lce_report import Grid, Lines, Loop, Table
from lce_report.figures.run import Colouring, run_section

pytestmark = pytest.mark.alone

STRIP = default_model().add("creep").set({"creep.share": 0.15, "creep.tau_v": 8.0})
Story = Callable[[User, WorkbenchState], Awaitable[None]]


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


def tell(folder: Path, story: Story, tab: str = "Runs") -> None:
    """A story on the page of a folder, whose runs are read."""

    @asynccontextmanager
    async def opened() -> AsyncIterator[tuple[User, WorkbenchState]]:
        state = WorkbenchState(folder)
        async with user_simulation(lambda: Page(state, tab) and None) as user:
            await state.open()
            await load(state)
            await user.open("/")
            tending = asyncio.create_task(tend(state))
            yield user, state
            tending.cancel()

    async def run() -> None:
        async with opened() as (user, state):
            await story(user, state)

    asyncio.run(run())


def with_model(folder: Path) -> WorkbenchState:
    """The runs read, one held out, and a model of them that does not creep."""
    state = WorkbenchState(folder)
    state.keep(STRIP.without("creep"), "by hand")
    asyncio.run(state.open({"later/other.csv": "test"}))
    return state


def test_runs_are_listed_and_what_is_none_says_why(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        for name in ("pulse.csv", "stairs.csv", "later/other.csv"):
            await user.should_see(name)
        await user.should_see("cannot be used: junk.csv: header 'time_s,volts'; expected time_s and of")
        assert set(state.runs("train")) == {"pulse.csv", "stairs.csv", "later/other.csv"}

    tell(folder, story)


def test_the_use_of_a_run_is_remembered_beside_the_runs(folder: Path) -> None:
    state = with_model(folder)
    again = WorkbenchState(folder)
    assert again.session.roles["later/other.csv"] == "test"
    assert again.session.current == 1 and again.session.models == state.session.models
    assert again.model() == state.model()


def test_a_choice_draws_no_row_anew_so_that_the_next_click_arrives(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        def radio(name: str) -> ui.radio:
            (found,) = (e for e in user.find(kind=ui.radio).elements if e.props["aria-label"] == f"use of {name}")
            assert isinstance(found, ui.radio)
            return found

        first, second = radio("pulse.csv"), radio("stairs.csv")
        first.set_value("test")
        second.set_value("off")
        await user.should_see("no model yet")
        assert [state.session.roles[name] for name in ("pulse.csv", "stairs.csv")] == ["test", "off"]
        assert radio("pulse.csv") is first and radio("stairs.csv") is second
        state.set_role("stairs.csv", "train")  # on another page
        for _ in range(20):
            if second.value == "train":
                break
            await asyncio.sleep(0.05)
        assert second.value == "train"
        state.entries["pulse.csv"] = replace(state.entries["pulse.csv"], warnings=("its file was read anew",))
        await user.should_see("its file was read anew")
        assert radio("pulse.csv") is first and first.value == "test"

    tell(folder, story)


def test_a_run_that_was_interrupted_is_not_learnt_from_unless_asked_for(folder: Path) -> None:
    (folder / "stairs.yaml").write_text("outcome: interrupted\nconditions: {}\n")
    state = WorkbenchState(folder)
    asyncio.run(state.open())
    assert state.session.roles["stairs.csv"] == "off"
    state.set_role("stairs.csv", "train")
    asyncio.run(state.reopen())
    assert state.session.roles["stairs.csv"] == "train"


EARLY = """
import asyncio, multiprocessing, sys
from pathlib import Path
from lce_app.workbench.state import WorkbenchState
state = WorkbenchState(Path(sys.argv[1]))
state.read_early({"later/other.csv": "test"})
if sys.argv[2] == "kill":
    multiprocessing.active_children()[0].kill()
asyncio.run(state.open({"later/other.csv": "test"}))
assert not multiprocessing.active_children()
for name, entry in state.entries.items():
    print(name, state.session.roles[name], entry.error, entry.run and entry.run.displacement.value.sum())
"""
"""In a process of its own, as the reader is forked."""


@pytest.mark.parametrize("end", ["", "kill"])
def test_runs_are_read_early_by_another_process_or_else_by_the_server(folder: Path, end: str) -> None:
    done = subprocess.run([sys.executable, "-c", EARLY, folder, end], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    here = with_model(folder)
    for name, entry in here.entries.items():
        total = entry.run and entry.run.displacement and entry.run.displacement.value.sum()
        assert f"{name} {here.session.roles[name]} {entry.error} {total}\n" in done.stdout


def test_a_session_file_that_is_none_is_told_and_left_alone(folder: Path) -> None:
    file = folder / "workbench" / "session.yaml"
    file.parent.mkdir()
    file.write_text("format: something else\n")
    with pytest.raises(LceError, match=r"session\.yaml: no session of the workbench"):
        WorkbenchState(folder)
    assert file.read_text() == "format: something else\n"


def test_nothing_outside_of_the_folder_is_found(folder: Path) -> None:
    inside = folder / "later"
    (inside / "out.csv").symlink_to(folder / "pulse.csv")
    (inside / "up").symlink_to(folder)
    assert set(session.find_runs(inside)) == {"other.csv"}


def test_the_comparison_is_what_the_report_draws_with_every_sample(folder: Path) -> None:
    state = with_model(folder)
    drawn = "".join(str(block) for block in shares(state))
    assert "of the squared error of d" in drawn
    key = "test"
    figures._shown[key] = lambda: run_figures(state, "pulse.csv")
    block = figures.packed(key)
    del figures._shown[key]
    assert block is not None
    (length,) = struct.unpack("<I", block[:4])
    page = json.loads(block[4 : 4 + length])
    titles = [figure["title"] for figure in page["figures"]]
    assert "hysteresis loop: d over T" in titles and "laser power P" in titles
    run = state.entries["pulse.csv"].run
    assert run is not None and run.displacement is not None
    displacement = page["figures"][titles.index("displacement\u00a0d")]
    begin, n = displacement["curves"][0]["y"]
    numbers = np.frombuffer(block[4 + length :], "<f4")
    assert numbers[begin : begin + n] == pytest.approx(1e3 * run.displacement.value, rel=1e-6)


def test_a_cell_of_the_shares_lights_its_samples_up(folder: Path) -> None:
    comparison = with_model(folder).comparison()
    assert comparison is not None
    quarters = comparison.shares[DISPLACEMENT].conditions
    ramp = [share for share in quarters if share.branch == "cooling" and not share.held]
    found = picked_samples(comparison, "displacement condition", 2, 1)
    seconds = sum(to - since for spans in found.values() for since, to in spans)
    total = sum(run.run.displacement.time_s[-1] for run in comparison.runs if run.run.displacement is not None)
    assert seconds / total == pytest.approx(ramp[1].sample_share, abs=0.01)
    assert set(picked_samples(comparison, "displacement cycle", 0, 0)) == {"pulse", "stairs", "other"}
    assert not any(picked_samples(comparison, "", 0, 0).values())


def test_a_comparison_without_a_model_says_what_to_do(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see("A model and a run are needed")
        state.keep(STRIP, "by hand")
        await user.should_see(marker="shares")

    tell(folder, story, "Compare")


ODD = {
    "keys that are no text": "conditions: {1: 2, null: [1], note: {a: {b: 1}}}",
    "numbers that are none": "conditions: {load_n: .inf, ambient_c: .nan, x: 1e400, strip_length_m: 1e-320}",
    "a number of 400 digits": f"conditions: {{note: {'9' * 400}}}",
    "a list for a text": "protocol: [1]",
    "control characters": 'conditions: {"a\\0b": "\\a"}',
    "names of one letter": "outcome: x\nconditions: {_: 1, _m: 5, m: ''}",
    "counts below zero": "messages: {a: -1}\nlost: {/lce/temperature: -5}",
    "a list": "- 1",
    "aliases": "a: &a [1]\nconditions: {note: *a}",
    "depth": f"conditions: {{note: {'[' * 300}{']' * 300}}}",
}


@pytest.mark.parametrize("odd", ODD.values(), ids=ODD)
def test_an_odd_file_beside_a_run_leaves_the_page_alone(folder: Path, odd: str) -> None:
    (folder / "pulse.yaml").write_text(f"format: lce-experiment-1\n{odd}\n")

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see(marker="run pulse.csv")
        await user.should_see(marker="run stairs.csv")
        assert state.entries["stairs.csv"].run is not None
        for tab in TABS:
            user.find(kind=ui.tab, content=tab).click()

    tell(folder, story, "Runs")


@pytest.mark.parametrize(
    ("former", "seen"),
    [
        ("Look", "A model and a run are needed"),
        ("Learn", "A model and a run to learn from are needed"),
        ("Tell apart", "A model is needed. Fit one"),
        ("Take away", "There is no model yet"),
    ],
)
def test_a_link_with_the_former_name_of_a_tab_opens_it(folder: Path, former: str, seen: str) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see(seen)

    tell(folder, story, former)


BENCH = {"host": "bench.lab:8080"}
HERE = {"host": "localhost:8080"}


@pytest.mark.parametrize(
    ("listens", "headers", "query", "status"),
    [
        ("127.0.0.1", HERE, "token=secret", 200),
        ("127.0.0.1", HERE, "", 403),
        ("127.0.0.1", HERE, "token=guess", 403),
        ("127.0.0.1", {"host": "127.0.0.1:8080"}, "token=secret", 200),
        ("127.0.0.1", {"host": "[::1]:8080"}, "token=secret", 200),
        ("127.0.0.1", {"host": "rebound.example:8080"}, "token=secret", 403),
        ("127.0.0.1", HERE | {"origin": "http://localhost:8080"}, "token=secret", 200),
        ("127.0.0.1", HERE | {"origin": "http://other.example"}, "token=secret", 403),
        ("127.0.0.1", HERE | {"origin": "http://localhost:8081"}, "token=secret", 403),
        ("127.0.0.1", HERE | {"origin": "null"}, "token=secret", 403),
        ("127.0.0.1", HERE | {"origin": "http://["}, "token=secret", 403),
        ("127.0.0.1", {}, "token=secret", 400),
        ("127.0.0.1", {"host": "["}, "token=secret", 400),
        ("127.0.0.1", {"host": "localhost:8080@x\xff"}, "token=secret", 400),
        ("127.0.0.1", HERE, "token=%ff%00\xe9", 403),
        ("127.0.0.1", HERE | {"cookie": "lce_workbench_8080=secret"}, "", 200),
        ("127.0.0.1", HERE | {"cookie": "a b:c=1; lce_workbench_8081=other; lce_workbench_8080=secret"}, "", 200),
        ("127.0.0.1", HERE | {"cookie": "lce_workbench_8081=secret"}, "", 403),
        ("127.0.0.1", HERE | {"cookie": 'lce_workbench_8080="\xe9'}, "", 403),
        ("0.0.0.0", BENCH, "token=guess", 403),
        ("0.0.0.0", BENCH, "token=secret", 200),
        ("0.0.0.0", BENCH | {"cookie": "lce_workbench_8080=secret"}, "", 200),
        ("0.0.0.0", BENCH | {"origin": "https://bench.lab:8080"}, "token=secret", 200),
    ],
)
def test_who_is_answered(listens: str, headers: dict[str, str], query: str, status: int) -> None:
    sent: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        page = [(b"content-type", b"text/html"), (b"content-length", b"31")]
        await send({"type": "http.response.start", "status": 200, "headers": page})
        await send({"type": "http.response.body", "body": b"<p>&lt;script><", "more_body": True})
        await send({"type": "http.response.body", "body": b"script>1</script>"})

    async def receive() -> dict[str, Any]:
        return {}

    async def send(message: dict[str, Any]) -> None:
        sent.append(message)

    coded = [(key.encode(), value.encode("latin-1")) for key, value in headers.items()]
    for kind in ("http", "websocket"):
        sent.clear()
        scope = {"type": kind, "method": "GET", "path": "/", "headers": coded, "query_string": query.encode("latin-1")}
        served = Starlette(routes=[Mount("/", app=app)])
        protect(served, listens, "secret")
        asyncio.run(served(scope, receive, send))
        answer = sent[0]
        assert answer == {"type": "websocket.close", "code": 1008} or answer["status"] == status
        told = dict(answer.get("headers", []))
        assert (told.get(b"set-cookie", b"").startswith(b"lce_workbench_8080=secret;")) == (
            status == 200 and "token=secret" in query
        )
        if status == 200:
            policy, body = told[b"content-security-policy"].decode(), sent[1]["body"].decode()
            (nonce,) = re.findall(r"script-src 'self' 'nonce-([\w-]+)' 'unsafe-eval';", policy)
            assert body == f'<p>&lt;script><script nonce="{nonce}">1</script>'
            assert told[b"content-length"].decode() == str(len(body)) and policy.startswith("default-src 'none'")


def ended(state: WorkbenchState, timeout_s: float = 60.0) -> Job:
    """The job of the workbench, when it is over."""
    assert state.job is not None
    state.job.wait(timeout_s)
    state.poll()
    assert not state.working
    return state.job


def test_a_job_tells_where_it_is_and_what_follows_is_done(folder: Path) -> None:
    state, followed = WorkbenchState(folder), []
    state.start("Count", counting, lambda: followed.append(True), out=folder / "counted")
    with pytest.raises(LceError, match="Count is under way"):
        state.start("Count", counting, out=folder / "again")
    job = ended(state)
    assert job.state == "done" and followed == [True] and (folder / "counted").exists()
    assert job.steps[0].label == "starting"
    assert job.steps[0].seconds < 5.0


def test_a_gentle_job_that_is_stopped_while_it_starts_ends_in_order(folder: Path) -> None:
    state = WorkbenchState(folder)
    state.record("Run", endless, folder / "never")
    state.stop()
    job = state.job
    assert job is not None
    for _ in range(100):
        job.poll()
        job.wait(0.1)
        if job.state != "running":
            break
    assert (job.state, job.error) == ("cancelled", "")


def test_the_server_ends_a_gentle_job_that_has_just_begun(folder: Path) -> None:
    state = WorkbenchState(folder)
    state.record("Run", endless, folder / "never")
    state.close()
    assert state.job is not None and state.job.state == "cancelled"


def test_the_warnings_of_a_result_are_shown(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        state.start("Warn", warning)
        await user.should_see("Warn: stranger: is it of another strip?", retries=50)
        assert state.job is not None and state.job.state == "done"

    tell(folder, story)


def test_a_job_fits_as_the_command_does_and_passes_its_warnings_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[fit.Options] = []

    def fitted(
        runs: Sequence[Path],
        out: Path,
        choice: fit.ModelChoice,
        options: fit.Options = fit.DEFAULTS,
        progress: Progress = silent,
    ) -> fit.Fits:
        asked.append(options)
        return fit.Fits((), ("stranger: is it of another strip?",))

    monkeypatch.setattr(fit, "fit", fitted)
    warnings = tasks.fit(
        [tmp_path / "a.csv"], ModelChoice("lumped", "equilibrium"), tmp_path / "m.yaml", progress=silent
    )
    assert asked == [fit.Options()] and warnings == ("stranger: is it of another strip?",)


def test_what_a_job_finds_wanting_is_one_line(folder: Path) -> None:
    state = WorkbenchState(folder)
    state.start("Refuse", refusing)
    assert (ended(state).state, state.job and state.job.error) == ("failed", "no run")


def test_a_crashed_job_costs_neither_page_nor_history(folder: Path) -> None:
    state = with_model(folder)
    state.start_model("Crash", crashing, "never", 1)
    job = ended(state)
    assert job.state == "failed" and "its process ended" in job.error
    assert [kept.number for kept in state.session.models] == [1]
    state.start("Count", counting, out=folder / "counted")
    assert ended(state).state == "done"


def test_a_job_is_cancelled(folder: Path) -> None:
    async def story(user: User, state: WorkbenchState) -> None:
        state.start("Wait", endless, out=folder / "never")
        await user.should_see("Wait: ", retries=50)
        user.find("Cancel").click()
        await user.should_see("Wait was cancelled")
        assert state.job is not None and state.job.state == "cancelled"

    tell(folder, story)


def test_the_history_says_how_the_error_fell_and_which_commands_do_the_same(folder: Path) -> None:
    state = with_model(folder)
    state.keep(STRIP, "creep added to model 1")
    table, sides = drawings.history(state)
    assert isinstance(table, Table) and isinstance(sides, Grid)
    displacement = sides.figures[1]
    assert isinstance(displacement, Lines) and len(displacement.curves) == 2
    assert all(curve.y[1] < 0.5 * curve.y[0] for curve in displacement.curves)
    assert displacement.y_axis.from_zero
    assert [row[0] for row in table.rows] == ["1", "2"]
    assert table.rows[1][2] == f"{displacement.curves[0].y[1]:.3g}"
    model = "--model workbench/model-2.yaml --report"
    assert commands(state) == [
        f"lce compare pulse.csv stairs.csv later/other.csv {model} compare.html",
        f"lce diagnose pulse.csv stairs.csv --test later/other.csv {model} diagnose.html",
    ]


def test_any_number_of_models_stand_over_one_run_with_their_errors(folder: Path) -> None:
    state = with_model(folder)
    state.keep(STRIP, "creep added to model 1")
    table, figures = models_over_run(state, "pulse.csv", [2, 1])
    assert isinstance(table, Table) and isinstance(figures, Grid)
    assert [row[0] for row in table.rows] == ["model 1", "model 2"]
    _, displacement = figures.figures
    assert isinstance(displacement, tuple)
    values, residuals = displacement
    assert isinstance(values, Lines) and isinstance(residuals, Lines)
    assert [curve.label for curve in values.curves] == ["measured", "model 1", "model 2"]
    worse, better = (float(np.sqrt(np.mean(curve.y**2))) for curve in residuals.curves)
    assert float(table.rows[0][4]) == pytest.approx(worse, rel=5e-3)
    assert better < 0.5 * worse and float(table.rows[1][5]) == pytest.approx(1.0, abs=0.1)
    assert models_over_run(state, "pulse.csv", []) == []


def test_a_file_that_cannot_be_read_costs_only_what_needs_it(folder: Path) -> None:
    state = with_model(folder)
    state.keep(STRIP, "by hand")
    state.session.model_file(1).write_text("format: something else\n")
    state.session.diagnosis_file(2).write_text("{}")

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see(content="model-1.yaml")
        user.find("Diagnose", kind=ui.tab).click()
        await user.should_see(content="diagnosis-2.json: not what the workbench wrote")
        user.find("Runs", kind=ui.tab).click()
        await user.should_see("pulse.csv")

    tell(folder, story, "Add")


def test_a_diagnosis_of_an_earlier_version_is_to_be_made_again(folder: Path) -> None:
    state = with_model(folder)
    old = {"verdict": "missing", "sentences": ["creep is missing."], "added": ["creep"], "candidates": []}
    state.session.diagnosis_file(1).write_text(json.dumps(old))

    async def story(user: User, state: WorkbenchState) -> None:
        await user.should_see(content="diagnosis-1.json: made by an earlier version: diagnose again")
        await user.should_see(marker="diagnose")

    tell(folder, story, "Diagnose")


def test_curves_follow_a_slider_and_what_they_show_can_be_kept(folder: Path) -> None:
    with_model(folder)
    model = WorkbenchState(folder).model()
    assert model is not None

    async def story(user: User, state: WorkbenchState) -> None:
        before = model["lumped.gain"]
        user.find(marker="slider lumped.tau").trigger("move", 900)
        user.find(marker="back").click()
        user.find(marker="slider lumped.gain").trigger("move", 900)
        user.find(marker="keep").click()
        await user.should_see("model 2: by hand")
        moved = state.model()
        assert moved is not None and moved["lumped.gain"] > before
        assert moved["lumped.tau"] == model["lumped.tau"]

    tell(folder, story, "Add")


def test_bounds_that_are_set_are_those_of_the_next_model(folder: Path) -> None:
    with_model(folder)

    async def story(user: User, state: WorkbenchState) -> None:
        for marker, number in (("bounds from", 2.0), ("bounds to", 1e4)):
            for element in user.find(marker=marker).elements:
                assert isinstance(element, ui.number)
                element.value = number
        chosen = state.model()
        assert chosen is not None
        user.find(marker="set bounds").click()
        key = next(value.key for value in chosen.values if not value.fixed)
        await user.should_see(f"model 2: bounds of {key}: 2 to 10000")
        bounded = state.model()
        assert bounded is not None
        value = bounded.values[bounded.index(key)]
        assert (value.lower, value.upper) == (2.0, 1e4)

    tell(folder, story, "Add")


def test_curves_by_hand_are_what_the_model_says(folder: Path) -> None:
    state = with_model(folder)
    model, comparison = state.model(), state.comparison()
    assert model is not None and comparison is not None
    run = state.runs("train")["pulse.csv"]
    for channel, compared in next(found for found in comparison.runs if found.run.name == run.name).channels.items():
        curve = ByHand.of(model, run).curves(model)[f"{drawings.title(channel)}/{LABEL}"]
        assert curve == pytest.approx(channel.display.from_si(channel.recorded.to_si(compared.modelled)))


def test_the_loop_is_coloured_by_branch_or_cycle(folder: Path) -> None:
    comparison = with_model(folder).comparison()
    assert comparison is not None
    (other,) = [run for run in comparison.runs if run.run.name == "other"]
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
    assert set(comparison.shares[DISPLACEMENT].runs) == {f"{folder.name}/other", "stairs", "later/other"}


@pytest.mark.parametrize("protocol", ["../outside.csv", "/etc/hostname", "waves", "pulse.csv/../../outside.csv"])
def test_a_wave_from_outside_of_the_folder_is_refused(folder: Path, protocol: str) -> None:
    (folder.parent / "outside.csv").write_text("time_s,power_w\n0,1\n1,0\n")

    async def story(user: User, state: WorkbenchState) -> None:
        (entry,) = user.find(kind=ui.input, marker="protocol").elements
        entry.value = protocol
        user.find(marker="start").click()
        await user.should_see(f"{protocol}: neither a protocol nor a CSV file in this folder")
        assert state.job is None

    tell(folder, story, "Bench")


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


def test_the_laser_of_the_real_bench_is_armed_by_a_button_that_tells_a_refusal(
    folder: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    ros2 = tmp_path_factory.mktemp("bin") / "ros2"
    ros2.write_text('#!/bin/sh\necho "SetBool_Response(success=$(cat $0.says))"\n')
    ros2.chmod(0o755)
    monkeypatch.setenv("PATH", str(ros2.parent), prepend=":")

    async def story(user: User, state: WorkbenchState) -> None:
        monkeypatch.setattr(state.monitor, "open", lambda: 7)
        for says, seen in (("False, message='not armed: 1 W are commanded'", "1 W are commanded"), ("True", "armed")):
            ros2.with_name("ros2.says").write_text(says)
            user.find(marker="arm").click()
            await user.should_see(seen, retries=50)

    tell(folder, story, "Bench")
