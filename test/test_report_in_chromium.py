# SPDX-License-Identifier: Apache-2.0
"""The report in a real browser: every figure is drawn, nothing complains, nothing is fetched, figures move together."""

import html
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lce_analysis.compare import compare
from lce_analysis.experiment import Run, Series
from lce_analysis.report import render_comparison
from lce_model import default_model, simulate

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--hide-scrollbars", "--enable-logging=stderr",
    "--virtual-time-budget=10000",
)  # fmt: skip
PROBE = """<script>
(async () => {
  const wait = (ms) => new Promise((next) => setTimeout(next, ms));
  while (!document.body.dataset.drawn) await wait(20);
  const figures = [...document.querySelectorAll("figure[data-figure]")];
  const look = () => figures.map((f) => f.querySelector("canvas").toDataURL());
  const moved = (before) => {
    const now = look();
    return figures.map((f) => +f.dataset.figure).filter((n, i) => now[i] !== before[i]);
  };
  const over = figures[0].querySelector(".u-over"), box = over.getBoundingClientRect();
  const at = { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2, bubbles: true };
  const resources = performance.getEntriesByType("resource").map((entry) => entry.name);
  const seen = { fetched: resources.filter((name) => !name.startsWith("data:")) };
  let before = look();
  over.dispatchEvent(new WheelEvent("wheel", { ...at, deltaY: -100, ctrlKey: true, cancelable: true }));
  await wait(200);
  seen.zoomed = moved(before);
  over.dispatchEvent(new MouseEvent("mouseenter", at));
  over.dispatchEvent(new MouseEvent("mousemove", at));
  await wait(200);
  seen.dots = [...document.querySelectorAll(".dot")].filter((dot) => dot.style.display === "block").length;
  seen.legend = figures[1].querySelector(".u-legend").textContent;
  before = look();
  document.getElementById("theme").click();
  await wait(200);
  seen.themed = moved(before).length;
  document.body.dataset.probe = JSON.stringify(seen);
})();
</script></body>"""

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
Browse = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def report() -> str:
    """Two short runs of a strip beside a model of it that is wrong in one parameter."""
    model = default_model("lumped", "equilibrium")
    runs = []
    for k, name in enumerate(("first", "second")):
        rng = np.random.default_rng(k)
        time = np.arange(0.0, 40.0, 0.01)
        power = np.where((time > 1.0) & (time < 15.0 + k), 1.2, 0.0)
        made = simulate(model, time, power)
        seen_t = made.temperature_k + 0.06 * rng.standard_normal(time.size)
        seen_d = made.displacement_m + 4e-6 * rng.standard_normal(time.size)
        runs.append(
            Run(
                name,
                Path(name),
                "0" * 64,
                Series(time, power),
                Series(time[::10], seen_t[::10]),
                Series(time, seen_d),
                {},
            )
        )
    key = "lumped.tau"
    return render_comparison(compare(model.set({key: 1.05 * model[key]}), runs))


@pytest.fixture
def browse(tmp_path: Path) -> Browse:
    def run(page: str, *flags: str, place: str = "") -> subprocess.CompletedProcess[str]:
        file = tmp_path / "report.html"
        file.write_text(page, encoding="utf-8")
        command = [str(CHROMIUM), *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", *flags, f"{file.as_uri()}{place}"]
        return subprocess.run(command, capture_output=True, text=True, timeout=90.0, check=True)

    return run


def _state(dom: str) -> dict[str, str]:
    body = re.search(r"<body[^>]*>", dom)
    assert body is not None
    return dict(re.findall(r'data-(\w+)="([^"]*)"', body.group()))


def _probe(state: dict[str, str]) -> dict[str, Any]:
    assert "error" not in state
    found: dict[str, Any] = json.loads(html.unescape(state["probe"]))
    return found


def test_every_figure_is_drawn_and_nothing_complains(report: str, browse: Browse) -> None:
    seen = browse(report, "--dump-dom", "--window-size=1024,900", place="#check")
    state = _state(seen.stdout)
    assert "error" not in state and "CONSOLE" not in seen.stderr
    assert int(state["figures"]) == report.count("data-figure=") > 10
    assert state["drawn"] == state["inked"] == state["figures"]


def test_an_empty_figure_would_be_noticed(report: str, browse: Browse) -> None:
    blank = report.replace("for (let i = 0; i < xs.length; i++) {", "for (let i = 0; i < 0; i++) {")
    assert blank != report
    state = _state(browse(blank, "--dump-dom", place="#check").stdout)
    assert int(state["inked"]) < int(state["figures"])


def test_an_error_in_the_script_would_be_noticed(report: str, browse: Browse) -> None:
    broken = report.replace("figure.curves)", "figure.nonsense)")
    assert broken != report
    seen = browse(broken, "--dump-dom")
    state = _state(seen.stdout)
    assert "not iterable" in state["error"] and "drawn" not in state


@pytest.mark.parametrize("beacon", ["", '<img alt="" src="http://localhost:9/beacon.png">'])
def test_the_page_fetches_nothing_even_where_it_may(report: str, browse: Browse, beacon: str) -> None:
    free = re.sub("<meta http-equiv.*?>", beacon, report).replace("</body>", PROBE)
    seen = _probe(_state(browse(free, "--dump-dom").stdout))
    assert seen["fetched"] == re.findall('src="(http[^"]*)"', beacon)


def test_the_page_may_not_fetch(report: str, browse: Browse) -> None:
    seen = browse(report.replace("</main>", '<img alt="" src="http://localhost:9/beacon.png"></main>'), "--dump-dom")
    assert "Content Security Policy" in seen.stderr


def test_figures_of_a_run_move_together_and_others_stay(report: str, browse: Browse) -> None:
    probed = report.replace("</body>", PROBE)
    seen = _probe(_state(browse(probed, "--dump-dom", "--window-size=1400,900").stdout))
    figures = json.loads(re.findall(r'id="figures">(.*?)</script>', report, re.DOTALL)[0])
    assert figures[0]["linked"] == "first"
    assert seen["zoomed"] == [i for i, f in enumerate(figures) if f["linked"] == "first"]
    assert seen["dots"] >= 2  # on the loop: where it is measured, and where the model is
    assert re.search(r"time[\d.]+ smeasured[\d.]+ °Cmodel[\d.]+ °C", seen["legend"])
    assert seen["themed"] == len(figures)


@pytest.mark.parametrize(("scheme", "setting"), [("dark", 0), ("light", 1)])
def test_the_page_follows_the_system_to_dark(report: str, browse: Browse, scheme: str, setting: int) -> None:
    dom = browse(report, f"--blink-settings=preferredColorScheme={setting}", "--dump-dom").stdout
    assert f'data-theme="{scheme}"' in dom


def test_it_prints(report: str, browse: Browse, tmp_path: Path) -> None:
    paper = tmp_path / "report.pdf"
    browse(report, f"--print-to-pdf={paper}", "--no-pdf-header-footer")
    content = paper.read_bytes()
    assert content.startswith(b"%PDF") and len(re.findall(rb"/Type\s*/Page\b", content)) >= 3
