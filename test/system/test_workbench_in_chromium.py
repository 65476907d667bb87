# SPDX-License-Identifier: Apache-2.0
"""The story of the README on the page of `lce workbench`, in a real browser.

Open a campaign, see where the model fails, find what is missing, add it, export the model; and whether everybody
can read the page. With LCE_SCREENSHOTS set to a folder, pictures of the story are kept there.
"""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import pytest
from chromium import CHROMIUM, FLAGS, Axe, Page, expect, needs_chromium, sync_playwright
from run_command import experiment, until, values

from lce_data.units import KELVIN
from lce_model import default_model, load_model, save_model, simulate

SCRIPT = Path(__file__).parents[2] / "src" / "lce_app" / "bin" / "lce"
STRIP = default_model().add("creep").set({"creep.share": 0.15, "creep.tau_v": 8.0})
TABS = ("Runs", "Import", "Prepare", "Compare", "Diagnose", "Add", "Design", "Export", "Bench")
BEHIND_NODES = Path(__file__).parent / "chromium_behind_nodes.sh"
JOB_MS = 90_000
ACTION_MS = 60_000
"""A click or a filled field waits for the page, which runs behind the nodes and on a busy machine gets little."""
CONTRAST = {"runOnly": ["color-contrast"]}

pytestmark = [pytest.mark.alone, needs_chromium]


def record(path: Path, power: np.ndarray, seed: int) -> None:
    """A CSV of a strip that creeps."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(power.size) / 100.0
    made = simulate(STRIP, time_s, power)
    temperature = made.measured_temperature_k - KELVIN + 0.06 * rng.standard_normal(time_s.size)
    displacement = made.measured_displacement_m + 4e-6 * rng.standard_normal(time_s.size)
    table = np.column_stack([time_s, power, temperature, displacement])
    head = "time_s,power_w,temperature_c,displacement_m"
    np.savetxt(path, table, "%.8g", ",", header=head, comments="")


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    t = np.arange(0.0, 40.0, 0.01)
    record(folder / "pulse.csv", np.where((t > 1.0) & (t < 16.0), 2.3, 0.0), 1)
    record(folder / "stairs.csv", np.select([t < 10.0, t < 18.0, t < 26.0], [1.0, 2.2, 1.2], 0.0), 2)
    record(folder / "unseen.csv", np.select([t < 7.0, t < 14.0, t < 24.0], [2.4, 0.5, 2.0], 0.0), 3)
    (folder / "junk.csv").write_text("time_s,volts\n0,1\n")
    save_model(STRIP.without("creep"), folder / "model.yaml")
    return folder


@contextmanager
def served(folder: Path, *words: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """The command as it is installed, in a session of its own, as in a terminal; and its address."""
    command = [sys.executable, str(SCRIPT), "workbench", str(folder), *words, "--port", "0"]
    env = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST")}  # NiceGUI asks for them
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=env, start_new_session=True) as server:
        try:
            assert server.stdout is not None
            found = server.stdout.readline().split()[0]
            until(lambda: answers(found), "the page")
            yield found, server
        finally:
            server.terminate()
            server.wait(20.0)


@pytest.fixture(scope="module")
def address(campaign: Path) -> Iterator[str]:
    with served(campaign, "--model", str(campaign / "model.yaml")) as (found, server):
        yield found
    assert server.returncode == -signal.SIGTERM


def answers(address: str) -> bool:
    try:
        with urlopen(address):
            return True
    except OSError:
        return False


@contextmanager
def shown(address: str, but: str = "no such words") -> Iterator[Page]:
    """A page whose errors, and whose requests to anywhere else, fail the test; but for those with certain words."""
    complaints: list[str] = []
    ours = (address.partition("?")[0], "data:", "blob:")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=BEHIND_NODES, args=FLAGS, env={**os.environ, "CHROMIUM": str(CHROMIUM)}
        )
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.set_default_timeout(ACTION_MS)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda m: complaints.append(m.text) if m.type in ("error", "warning") else None)
        page.on(
            "request",
            lambda r: None if r.url.startswith(ours) else complaints.append(f"asked {r.url}"),
        )
        page.goto(address)
        yield page
        browser.close()
    assert [complaint for complaint in complaints if but not in complaint] == []


@pytest.fixture
def page(address: str) -> Iterator[Page]:
    with shown(address) as page:
        yield page


def tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=name, exact=True).click()


def picture(page: Page, name: str) -> None:
    if folder := os.environ.get("LCE_SCREENSHOTS"):
        page.screenshot(path=f"{folder}/{name}.png", full_page=True)


def drawn(page: Page, figure: str) -> None:
    """The figure of that title holds something."""
    canvas = page.locator("figure:visible", has_text=figure).locator("canvas").first
    expect(canvas).to_be_visible()
    inked = "(c) => new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size > 20"
    assert canvas.evaluate(inked), f"{figure} is empty"


def test_the_story_of_the_readme(page: Page, address: str, campaign: Path) -> None:
    expect(page.get_by_role("row", name="junk.csv")).to_contain_text("header 'time_s,volts'; expected")
    page.get_by_role("radiogroup", name="use of unseen.csv").get_by_role("radio", name="hold out").click()
    picture(page, "1-runs")

    tab(page, "Compare")
    expect(page.get_by_text("of the squared error of d").first).to_be_visible(timeout=JOB_MS)
    drawn(page, "hysteresis loop")
    cells = page.locator('[data-pick="displacement condition"]')
    power = page.locator("figure:visible", has_text="laser power P").locator("canvas")
    before = power.evaluate("(c) => c.toDataURL()")
    cells.nth(2).click()
    expect(cells.nth(2)).to_have_attribute("aria-pressed", "true")
    until_changed = "(c, before) => new Promise((done) => setInterval(() => c.toDataURL() !== before && done(), 50))"
    power.evaluate(until_changed, before)
    picture(page, "2-compare")

    tab(page, "Diagnose")
    page.get_by_role("button", name="Diagnose", exact=True).click()
    expect(page.get_by_label("progress of the job")).to_be_visible()
    expect(page.get_by_role("heading", name="An effect is missing")).to_be_visible(timeout=JOB_MS)
    expect(page.get_by_label("the answer")).to_contain_text("creep is missing")
    page.locator(".candidate", has_text="creep").first.get_by_role("button").first.click()
    expect(page.get_by_text("tau_v dd_c/dt = d - d_c")).to_be_visible()
    drawn(page, ", and creep")
    picture(page, "3-diagnose")
    assert page.context.browser is not None
    other = page.context.browser.new_page()
    other.goto(address)
    page.get_by_role("button", name="Add creep").click()
    expect(page.get_by_text("model 2: creep added to model 1")).to_be_visible(timeout=JOB_MS)

    expect(page.get_by_role("tab", name="Add", exact=True)).to_have_attribute("aria-selected", "true")
    drawn(page, "RMS error of displacement")
    expect(page.get_by_text("Model 1 (before) and model 2 (after).")).to_be_visible(timeout=20_000)
    slider = page.get_by_role("slider", name="creep.tau_v")
    slider.focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator(".hand .figures[data-replaced]")).to_be_visible()
    picture(page, "4-add")
    page.get_by_role("button", name="Undo").click()
    expect(other.get_by_text("model 1: from model.yaml")).to_be_visible()
    other.get_by_role("tab", name="Add", exact=True).click()
    other.get_by_role("button", name="use model 2").click()
    expect(page.get_by_text("model 2: creep added to model 1").first).to_be_visible()

    page.reload()
    expect(page.get_by_text("model 2: creep added to model 1").first).to_be_visible()
    tab(page, "Export")
    with page.expect_download() as download:
        page.get_by_role("button", name="Model (YAML)").click()
    model = load_model(download.value.path())
    assert model.effects == ("creep",) and model["creep.share"] == pytest.approx(0.15, abs=0.03)
    expect(page.get_by_text("lce add creep pulse.csv stairs.csv --test unseen.csv")).to_be_visible()
    picture(page, "5-export")

    tab(page, "Compare")
    figure = page.locator("figure:visible").filter(
        has=page.locator("figcaption", has_text=re.compile(r"^displacement\sd(?! of)"))
    )
    begins = {"CSV": b"time [s],measured d [mm],model d [mm]\n0,", "PNG": b"\x89PNG", "SVG": b"<?xml", "PDF": b"%PDF"}
    for kind, begin in begins.items():
        with page.expect_download() as download:
            figure.get_by_role("button", name=kind).first.click()
        assert Path(download.value.path()).read_bytes().startswith(begin)


def test_a_run_that_is_dropped_on_the_page_is_among_the_runs(tmp_path: Path) -> None:
    rows = "".join(f"{t / 10},1.0,{25.0 + t / 10:.2f}\\n" for t in range(50))
    drop = f"""() => {{
        const files = new DataTransfer();
        files.items.add(new File(["time_s,power_w,temperature_c\\n{rows}"], "dropped.csv"));
        document.body.dispatchEvent(new DragEvent("drop", {{ dataTransfer: files, bubbles: true, cancelable: true }}));
    }}"""
    with served(tmp_path) as (address, _), shown(address) as page:
        page.evaluate(drop)
        expect(page.get_by_role("radiogroup", name="use of runs/dropped.csv")).to_be_visible(timeout=20_000)


def test_a_foreign_file_becomes_a_run(tmp_path: Path) -> None:
    t = np.arange(0.0, 60.0, 0.5)
    warm = 22.0 + 30.0 * np.where(t < 30.0, 1.0 - np.exp(-t / 8.0), np.exp(-(t - 30.0) / 8.0))
    rows = [
        f"{a:g};{b:g};{c:.3f}".replace(".", ",") for a, b, c in zip(t, np.where(t < 30.0, 80.0, 0.0), warm, strict=True)
    ]
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "day.csv").write_text("\n".join(["Time;Q1;T1", *rows]))
    (tmp_path / "folder").mkdir()
    with served(tmp_path / "folder") as (address, _), shown(address) as page:
        tab(page, "Import")
        with page.expect_file_chooser() as chooser:
            page.get_by_role("button", name="File from elsewhere").click()
        chooser.value.set_files(tmp_path / "elsewhere" / "day.csv")
        expect(page.get_by_role("row", name="Q1")).to_contain_text("0 … 80", timeout=20_000)
        drawn(page, "temperature")
        picture(page, "7-import")
        page.get_by_role("button", name="Import", exact=True).click()
        expect(page.get_by_role("row", name="runs/day.csv")).to_contain_text("T at 2 Hz", timeout=20_000)


REFUSED = "violates the following Content Security Policy directive"
MARK = "<img src=data:, onerror=window.ran=1><script>window.ran=2</script>"


def test_what_files_hold_is_shown_as_text(tmp_path: Path, campaign: Path) -> None:
    run = (campaign / "pulse.csv").read_text()
    names = ('a" :onclick="window.ran=3.csv', "b' onfocus='window.ran=4.csv", f"c {MARK.replace('/', '')}.csv")
    for name in names:
        (tmp_path / name).write_text(run)
    (tmp_path / "d.csv").write_text(run)
    (tmp_path / "d.yaml").write_text(f"conditions:\n  specimen: '{MARK}'\n  ? '{MARK}'\n  : '{MARK}'\n")
    os.mkfifo(tmp_path / "pipe.csv")
    with served(tmp_path, "--model", str(campaign / "model.yaml")) as (address, _), shown(address, REFUSED) as page:
        expect(page.get_by_role("row", name="d.csv")).to_contain_text(MARK, timeout=20_000)
        assert "token" not in page.url
        for name in names:
            expect(page.get_by_role("radiogroup", name=f"use of {name}", exact=True)).to_be_visible()
        record = {"between": [MARK, "b"], "protocol": MARK, "separation": 1.0, "hottest_c": 50.0, "command": MARK}
        for kind, text in (("json", json.dumps(record)), ("csv", "time_s,power_w\n0,0\n1,0\n")):
            (tmp_path / "workbench" / f"wave-1.{kind}").write_text(text)
        page.get_by_role("button", name="Read the folder anew").click()
        for name in TABS:
            tab(page, name)
            expect(page.locator(".q-tab-panel")).to_be_visible()
            page.wait_for_load_state("networkidle")
        tab(page, "Design")
        expect(page.get_by_role("heading", name=f"{MARK} or b")).to_be_visible(timeout=20_000)
        assert page.evaluate("window.ran") is None
        with page.expect_console_message(lambda message: REFUSED in message.text):
            page.evaluate("(html) => document.body.insertAdjacentHTML('beforeend', html)", MARK)
        assert page.evaluate("window.ran") is None


def test_everybody_can_read_it(page: Page) -> None:
    axe, found = Axe(), []
    for name in TABS:
        tab(page, name)
        expect(page.locator(".q-tab-panel")).to_be_visible()
        page.wait_for_load_state("networkidle")
        for scheme, options in (("light", None), ("dark", CONTRAST)):
            page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
            expect(page.locator(f'html[data-theme="{scheme}"]')).to_be_attached()
            result = axe.run(page, options=options)
            found += [f"{name}, {scheme}: {result.generate_report()}"] if result.violations_count else []
            picture(page, f"{scheme}-{name}")
    assert not found, "\n".join(found)


def test_the_keyboard_reaches_every_tab(page: Page) -> None:
    page.get_by_role("tab", name="Runs", exact=True).focus()
    for name in TABS[1:]:
        page.keyboard.press("ArrowRight")
        page.keyboard.press("Enter")
        expect(page.get_by_role("tab", name=name, exact=True)).to_have_attribute("aria-selected", "true")


FOCUSED = """() => {
    const at = document.activeElement, label = at.closest(".q-field")?.querySelector(".q-field__label");
    return at.getAttribute("aria-label") ?? label?.textContent ?? at.textContent.trim();
}"""


def tabbed_to(page: Page, name: str, most: int = 40) -> list[str]:
    """Press Tab until that element has the focus; the names of all that had it on the way."""
    names: list[str] = []
    while len(names) < most:
        page.keyboard.press("Tab")
        names.append(str(page.evaluate(FOCUSED)))
        if names[-1] == name:
            return names
    raise AssertionError(f"{name} was not among {names}")


PLACE = """() => {
    const panel = document.querySelector(".q-tab-panel"), at = document.activeElement;
    return panel.contains(at) ? [...panel.querySelectorAll("*")].indexOf(at) : -1;
}"""


def test_the_tab_key_goes_through_every_tab_in_the_order_of_the_page(page: Page) -> None:
    for name in TABS:
        tab(page, name)
        panel = page.locator(".q-tab-panel:not([data-seen])")  # that of the tab before goes a moment later
        expect(panel).not_to_have_text("loading …", timeout=60_000)
        page.wait_for_load_state("networkidle")
        panel.evaluate("(panel) => { panel.dataset.seen = ''; panel.tabIndex = -1; panel.focus(); }")
        places, names = [], []
        while len(places) < 200:
            page.keyboard.press("Tab")
            place = int(page.evaluate(PLACE))
            if place < 0:
                break
            places.append(place)
            names.append(str(page.evaluate(FOCUSED)))
        assert places and place < 0, f"{name}: the focus does not leave the tab: {names}"
        assert places == sorted(set(places)), f"{name}: {names}"
        assert all(names), f"{name}: something without a name has the focus: {names}"


@pytest.fixture
def preparing(campaign: Path, tmp_path: Path) -> Iterator[Page]:
    """The tab Prepare of a page of one run."""
    (tmp_path / "pulse.csv").write_bytes((campaign / "pulse.csv").read_bytes())
    with served(tmp_path) as (address, _), shown(address) as page:
        tab(page, "Prepare")
        expect(page.locator("figure:visible canvas")).to_have_count(3, timeout=60_000)
        yield page


def test_an_interval_that_is_dragged_over_is_left_out(preparing: Page) -> None:
    page = preparing
    over = page.locator(".u-over:visible").nth(1)
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 40, steps=4)
    page.mouse.up()
    expect(page.get_by_label("From [s]")).to_have_value(re.compile(r"^(19\.9|20)"))
    page.get_by_role("button", name="Leave the interval out").click()
    step = page.get_by_role("listitem").filter(has_text="cut all sensors")
    expect(step).to_have_text(re.compile(r"from (19\.9\d*|20\.?\d*) to (23\.9\d*|24\.?\d*) s"))
    drawn(page, "displacement")
    picture(page, "8-prepare")
    tab(page, "Runs")
    expect(page.get_by_role("row", name="pulse.csv")).to_contain_text("prepared: cut all sensors")
    page.keyboard.press("Control+z")
    expect(page.get_by_role("row", name="pulse.csv")).not_to_contain_text("prepared")
    page.get_by_role("button", name="Redo the preparation of pulse.csv").click()
    expect(page.get_by_role("row", name="pulse.csv")).to_contain_text("prepared: cut all sensors")


def test_a_run_is_prepared_by_the_keyboard_alone(preparing: Page) -> None:
    page = preparing
    page.get_by_role("tab", name="Prepare", exact=True).focus()
    on_the_way = tabbed_to(page, "From [s]")
    assert [name for name in on_the_way if name] == on_the_way, "something without a name has the focus"
    page.keyboard.type("20")
    tabbed_to(page, "To [s]", 1)
    page.keyboard.type("24")
    tabbed_to(page, "Leave the interval out", 3)
    page.keyboard.press("Enter")
    step = page.get_by_role("listitem").filter(has_text="cut all sensors")
    expect(step).to_be_visible(timeout=20_000)
    rest = tabbed_to(page, "Remove step 1")
    assert [name for name in rest if name] == rest, "something without a name has the focus"
    for name in (
        "The interval is at rest",
        "clear the intervals at rest",
        "Take it off",
        "Resample",
        "Add its channels",
    ):
        assert name in rest
    page.keyboard.press("Enter")
    expect(step).to_have_count(0, timeout=20_000)
    expect(page.get_by_text("None: the run is used as it was recorded.").locator("..")).to_be_focused()
    page.keyboard.press("Control+z")
    expect(step).to_be_visible(timeout=20_000)
    page.keyboard.press("Control+Shift+Z")
    expect(step).to_have_count(0, timeout=20_000)


@pytest.mark.parametrize(
    "end",
    [lambda pid: os.killpg(pid, signal.SIGINT), lambda pid: os.kill(pid, signal.SIGKILL)],
    ids=["Ctrl-C", "kill -9"],
)
def test_however_the_server_ends_a_run_ends_in_the_dark(tmp_path: Path, end: Callable[[int], None]) -> None:
    with served(tmp_path) as (address, server):
        with shown(address) as page:
            tab(page, "Bench")
            page.get_by_label("Protocol").fill("hold:power=1.5,hold=60")
            page.get_by_role("button", name="Run on the simulated bench").click()
            expect(page.get_by_text(" P 1.500 W")).to_be_visible(timeout=JOB_MS)
            picture(page, "6-bench")
        end(server.pid)
        server.wait(30.0)
        (run,) = tmp_path.glob("*_hold")
        until(lambda: "outcome" in experiment(run), "the end of the run")
    assert experiment(run)["outcome"] == "interrupted"
    power = values(run, "/lce/laser/power")[1]
    assert power.max() == 1.5 and power[-1] == 0.0
