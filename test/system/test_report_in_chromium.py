# SPDX-License-Identifier: Apache-2.0
"""The report in a real browser: every figure is drawn, nothing complains, nothing is fetched, figures move together."""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from chromium import CHROMIUM, FLAGS, Browser, Page, expect, needs_chromium, sync_playwright

from lce_analysis.comparison.compare import compare
from lce_data.marker import Marker
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate
from lce_report.pages.comparison import render_comparison

BEACON = '<img alt="" src="http://localhost:9/beacon.png">'
LOOK = "() => [...document.querySelectorAll('figure[data-figure] canvas')].map((canvas) => canvas.toDataURL())"

pytestmark = needs_chromium
Show = Callable[..., Page]


def run_of(model: Model, name: str, off_s: float) -> Run:
    """A short run, the laser on from 1 s to ``off_s``, which is marked."""
    rng = np.random.default_rng(int(off_s))
    time = np.arange(0.0, 40.0, 0.01)
    power = np.where((time > 1.0) & (time < off_s), 1.2, 0.0)
    made = simulate(model, time, power)
    seen_t = made.temperature_k + 0.06 * rng.standard_normal(time.size)
    seen_d = made.displacement_m + 4e-6 * rng.standard_normal(time.size)
    camera = Series(time[::10], seen_t[::10])
    run = Run.of(name, Series(time, power), camera, Series(time, seen_d), "0" * 64)
    return replace(run, markers=(Marker(off_s, "</script><b>dark"), Marker(20.0, "lamp on")))


@pytest.fixture(scope="module")
def report() -> str:
    """Two short runs of a strip beside a model of it that is wrong in one parameter."""
    model = default_model("lumped", "equilibrium")
    runs = [run_of(model, "first", 15.0), run_of(model, "second", 16.0)]
    key = "lumped.tau"
    return render_comparison(compare(model.set({key: 1.05 * model[key]}), runs))


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def complaints() -> list[str]:
    """What the pages of a test wrote on the console, and their errors."""
    return []


@pytest.fixture
def show(browser: Browser, tmp_path: Path, complaints: list[str]) -> Iterator[Show]:
    pages: list[Page] = []

    def show(text: str, place: str = "", **options: object) -> Page:
        file = tmp_path / "report.html"
        file.write_text(text, encoding="utf-8")
        page = browser.new_page(viewport={"width": 1400, "height": 900}, **options)
        pages.append(page)
        page.on("console", lambda message: complaints.append(message.text))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(f"{file.as_uri()}{place}")
        page.wait_for_selector("body[data-drawn], body[data-error]")
        return page

    yield show
    for page in pages:
        page.close()


def _state(page: Page) -> dict[str, str]:
    state: dict[str, str] = page.evaluate("() => ({ ...document.body.dataset })")
    return state


def _unguarded(report: str, instead: str = "") -> str:
    """The report without its Content-Security-Policy, which runs no script that was changed."""
    return re.sub("<meta http-equiv.*?>", instead, report)


def _moved(page: Page, before: list[str], wanted: list[int]) -> list[int]:
    """The figures that look different, 100 ms after the wanted ones do, or after ten seconds."""
    for _ in range(100):
        now = page.evaluate(LOOK)
        moved = [i for i, picture in enumerate(now) if picture != before[i]]
        page.wait_for_timeout(100.0)
        if moved == wanted:
            break
    return [i for i, picture in enumerate(page.evaluate(LOOK)) if picture != before[i]]


def test_every_figure_is_drawn_and_nothing_complains(report: str, show: Show, complaints: list[str]) -> None:
    state = _state(show(report, "#check"))
    assert "error" not in state and complaints == []
    assert int(state["figures"]) == report.count("data-figure=") > 10
    assert state["drawn"] == state["inked"] == state["figures"]


def test_an_empty_figure_would_be_noticed(report: str, show: Show) -> None:
    blank = report.replace("for (let i = 0; i < xs.length; i++) {", "for (let i = 0; i < 0; i++) {")
    assert blank != report
    state = _state(show(_unguarded(blank), "#check"))
    assert int(state["inked"]) < int(state["figures"])


def test_an_error_in_the_script_would_be_noticed(report: str, show: Show) -> None:
    broken = report.replace("figure.curves)", "figure.nonsense)")
    assert broken != report
    state = _state(show(_unguarded(broken)))
    assert "not iterable" in state["error"] and "drawn" not in state


@pytest.mark.parametrize("beacon", ["", BEACON])
def test_the_page_fetches_nothing_even_where_it_may(report: str, show: Show, beacon: str) -> None:
    page = show(_unguarded(report, beacon))
    fetched = page.evaluate("() => performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert [name for name in fetched if not name.startswith("data:")] == re.findall('src="(http[^"]*)"', beacon)


def test_the_page_may_not_fetch(report: str, show: Show, complaints: list[str]) -> None:
    show(report.replace("</main>", f"{BEACON}</main>"))
    assert any("Content Security Policy" in complaint for complaint in complaints)


def test_no_script_runs_but_those_of_the_page(report: str, show: Show, complaints: list[str]) -> None:
    ran = "document.body.dataset.ran = 1"
    smuggled = f"<script>{ran}</script><img alt='' src='data:,' onerror='{ran}'>"
    page = show(report.replace("</main>", f"{smuggled}</main>"))
    page.wait_for_load_state("load")
    assert "ran" not in _state(page)
    assert sum("Content Security Policy" in complaint for complaint in complaints) == 2


def test_figures_of_a_run_move_together_and_others_stay(report: str, show: Show, complaints: list[str]) -> None:
    page = show(report)
    figures = json.loads(re.findall(r'id="figures">(.*?)</script>', report, re.DOTALL)[0])
    assert figures[0]["linked"] == "first"
    page.locator(".u-over").first.hover()
    before = page.evaluate(LOOK)
    page.keyboard.down("Control")
    page.mouse.wheel(0.0, -100.0)
    page.keyboard.up("Control")
    of_the_run = [i for i, figure in enumerate(figures) if figure["linked"] == "first"]
    assert _moved(page, before, of_the_run) == of_the_run

    dots = page.locator(".dot >> visible=true")  # where it is measured, and where the model is
    expect(dots.nth(1)).to_be_visible()
    legend = page.locator("figure[data-figure='1'] .u-legend").text_content() or ""
    assert re.search(r"time[\d.]+ smeasured[\d.]+ °Cmodel[\d.]+ °C", legend)

    before = page.evaluate(LOOK)
    page.locator("#theme").click()
    assert len(_moved(page, before, list(range(len(figures))))) == len(figures)
    assert complaints == []


def test_a_laser_that_is_off_is_not_drawn_beside_100_w(show: Show) -> None:
    model = default_model("lumped", "equilibrium")
    text = render_comparison(compare(model, [run_of(model, "off", 0.0), run_of(model, "on", 15.0)]))
    plots = "const plots = []"
    assert text.count(plots) == 1
    page = show(_unguarded(text.replace(plots, "const plots = window.plots = []")))
    shown = "plots.filter((p) => p.figure.title === 'laser power P').map((p) => [p.scales.y.min, p.scales.y.max])"
    off, on = page.evaluate(shown)
    assert off == [0.0, 1.0]
    assert on[0] == 0.0 and 1.2 < on[1] < 1.5


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_the_page_follows_the_system_to_dark(report: str, show: Show, scheme: str) -> None:
    page = show(report, color_scheme=scheme)
    assert page.locator("html").get_attribute("data-theme") == scheme


def test_it_prints(report: str, show: Show) -> None:
    content = show(report).pdf()
    assert content.startswith(b"%PDF") and len(re.findall(rb"/Type\s*/Page\b", content)) >= 3


@pytest.mark.parametrize("width", [390, 800])
def test_nothing_runs_off_a_narrow_page(report: str, show: Show, width: int) -> None:
    page = show(report)
    page.set_viewport_size({"width": width, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= width
