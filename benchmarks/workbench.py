# SPDX-License-Identifier: Apache-2.0
"""`lce workbench` in Chromium: how long a user waits, and the memory of a live view."""

import os
import re
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
from playwright.sync_api import Page, expect, sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "test" / "system"))

from chromium import CHROMIUM, FLAGS

from lce_data.units import KELVIN
from lce_model import default_model, save_model, simulate

STRIP = default_model().add("creep").set({"creep.share": 0.12, "creep.tau_v": 8.0})
TAB, THUMBNAIL = "[role=tab]:nth-child(4)", "svg[aria-label]"
RUNS, RUN_S, STARTS = 10, 1200.0, 5
LONG_S, STEPS = 600.0, 60
EMPTY = "from nicegui import ui; ui.run(lambda: ui.label('empty') and None, port={port}, show=False, reload=False)"
"""The least that a page of this kind needs."""
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
"""Python keeps its bytecode, as it does for a user: it would take a second to make it anew at every start."""
LOOK_S = 10.0
SETTLE_S = 8.0
"""After a start, until a job is begun: by then the process is there from which jobs are forked; and between starts."""
HEAT_UP_S = 60.0
"""Memory is not judged before."""


def measure(live_s: float) -> list[str]:
    """A campaign of ten runs, one long run, and a live view."""
    if CHROMIUM is None:
        return ["## `lce workbench`", "", "Not measured: no Chromium on this machine."]
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as place, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        rows = [*_campaign(page, Path(place) / "campaign"), *_long_run(page, Path(place) / "long")]
        rows += _live(page, Path(place) / "live", live_s)
        browser.close()
    table = ["| | measured | bar |", "|---|---|---|", *(f"| {a} | {b} | {c} |" for a, b, c in rows)]
    title = (
        f"## `lce workbench`, headless Chromium, server and browser on the same two cores, median of {STARTS} starts"
    )
    return [title, "", f"Load average before it began: {load:.1f}.", "", *table]


Rows = list[tuple[str, str, str]]


class Served:
    """The command, and when it was given."""

    def __init__(self, page: Page, folder: Path) -> None:
        port = _free_port()
        words = ["workbench", str(folder), "--model", str(folder / "model.yaml"), "--port", str(port)]
        self.began = time.perf_counter()
        command = [sys.executable, "-m", "lce_app.cli.main", *words]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=ENVIRONMENT)
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().split()[0]
        _wait_for(self.address)
        page.goto(self.address)
        _until(page, TAB)
        self.usable_s = time.perf_counter() - self.began

    def memory_mb(self) -> float:
        """Resident memory of the server, without its jobs."""
        status = Path(f"/proc/{self.process.pid}/status").read_text(encoding="utf-8")
        found = re.search(r"VmRSS:\s+(\d+)", status)
        assert found is not None
        return int(found.group(1)) / 1024.0

    def __enter__(self) -> "Served":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait(20.0)


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
    return port


def _wait_for(address: str) -> None:
    """Wait until a server listens, without asking it for a page. Raises TimeoutError after a minute."""
    url = urlsplit(address)
    latest = time.monotonic() + 60.0
    while time.monotonic() < latest:
        try:
            socket.create_connection((url.hostname, url.port)).close()
        except OSError:
            time.sleep(0.01)
        else:
            return
    raise TimeoutError(address)


def _until(page: Page, selector: str, count: int = 1) -> None:
    """Wait until a page shows so many of something, to the frame. Raises playwright's Error after a minute."""
    page.evaluate(SHOWN, [selector, count])


def _campaign(page: Page, folder: Path) -> Rows:
    """Ten runs of 1200 s; the first start is not counted, as it compiles."""
    folder.mkdir()
    time_s = np.arange(0.0, RUN_S, 0.01)
    for i in range(RUNS):
        record(folder / f"run-{i}.csv", 1.2 + np.sin(2.0 * np.pi * time_s / (20.0 + 3.0 * i)), i)
    save_model(STRIP.without("creep"), folder / "model.yaml")
    starts = np.array([_start(page, folder) for _ in range(STARTS + 1)][1:])
    empty, usable, opened, progress = np.median(starts, axis=0)
    fastest = starts.min(axis=0)
    return [
        ("command to an empty NiceGUI page", f"{empty:.1f} s (least {fastest[0]:.1f} s)", ""),
        ("command to page usable", f"{usable:.1f} s (least {fastest[1]:.1f} s), {usable / empty:.1f} × empty", "1.5 s"),
        (
            f"command to a campaign of {RUNS} runs open, {RUN_S:.0f} s each at 100 Hz, CSV",
            f"{opened:.1f} s (least {fastest[2]:.1f} s), {opened / empty:.1f} × empty",
            "2 s",
        ),
        ("click to the first progress of a job", f"{1e3 * progress:.0f} ms", "150 ms"),
    ]


def _start(page: Page, folder: Path) -> tuple[float, float, float, float]:
    """Seconds to an empty page, to the workbench's, to all runs of a folder on it; and from click to progress."""
    time.sleep(SETTLE_S)
    empty = _empty(page)
    with Served(page, folder) as served:
        _until(page, THUMBNAIL, RUNS)
        opened = time.perf_counter() - served.began
        page.get_by_role("tab", name="Diagnose").click()
        page.wait_for_timeout(1e3 * SETTLE_S)
        expect(page.get_by_role("button", name="Diagnose", exact=True)).to_be_enabled()
        progress: float = page.evaluate(BEGIN)
        page.get_by_role("button", name="Cancel").click()
    return empty, served.usable_s, opened, progress


def _empty(page: Page) -> float:
    """Seconds from the command to a page that shows one word."""
    port = _free_port()
    began = time.perf_counter()
    command = [sys.executable, "-c", EMPTY.format(port=port)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=ENVIRONMENT)
    try:
        _wait_for(f"http://localhost:{port}")
        page.goto(f"http://localhost:{port}")
        _until(page, ".nicegui-content > *")
        return time.perf_counter() - began
    finally:
        process.terminate()
        process.wait(20.0)


def _long_run(page: Page, folder: Path) -> Rows:
    """60 000 samples of everything, and the sliders on them."""
    folder.mkdir()
    time_s = np.arange(0.0, LONG_S, 0.01)
    record(folder / "long.csv", 1.2 + np.sin(2.0 * np.pi * time_s / 60.0), 1, camera=1)
    save_model(STRIP, folder / "model.yaml")
    with Served(page, folder):
        _until(page, THUMBNAIL)
        page.get_by_role("tab", name="Add").click()
        hand = page.locator(".hand .figures[data-drawn='2']")
        expect(hand).to_be_visible(timeout=60_000)
        page.reload()
        page.wait_for_load_state("networkidle")
        drawn = page.evaluate(DRAW)
        expect(hand).to_be_visible(timeout=60_000)
        follow = np.array(page.evaluate(SLIDE, STEPS))
    return [
        ("60 000 × 5 points drawn, from numbers to ink", f"{drawn:.2f} s", "1 s"),
        (
            f"slider to curves, {LONG_S:.0f} s at 100 Hz twice, 95 % of {STEPS} moves",
            f"{np.percentile(follow, 95.0):.0f} ms (median {np.median(follow):.0f} ms)",
            "100 ms",
        ),
    ]


SHOWN = """async ([selector, count]) => {
  const shown = () => [...document.querySelectorAll(selector)].filter((found) => found.getClientRects().length);
  const latest = performance.now() + 60e3;
  while (shown().length !== count) {
    if (performance.now() > latest) throw new Error(`no ${count} of ${selector} within a minute`);
    await new Promise(requestAnimationFrame);
  }
}"""
"""Looks at every frame; `expect` would look again after 0.1, 0.25, 0.5 s, and be as late."""
BEGIN = """async () => {
  const named = (found) => found.textContent.trim() === "Diagnose" && found.getClientRects().length;
  const button = [...document.querySelectorAll("button")].find(named);
  const shown = () => document.querySelector("[aria-label='progress of the job']")?.getClientRects().length;
  const begin = performance.now();
  button.click();
  while (!shown()) await new Promise(requestAnimationFrame);
  return (performance.now() - begin) / 1000;
}"""
DRAW = """async () => {
  const n = 60000, x = Array.from({ length: n }, (_, i) => 0.01 * i);
  const wave = (k) => x.map((t) => Math.sin(t / (3 + k)) + 0.01 * Math.sin(1e4 * t));
  const figures = [0, 1, 2, 3, 4].map((k) => ({
    title: `${k}`, xAxis: { name: "time", unit: "s" }, yAxis: { name: "y", unit: "1" }, linked: "all", height: 170,
    x, curves: [{ label: "y", role: "model", form: "line", y: wave(k) }],
  }));
  const place = document.createElement("div");
  place.className = "figures";
  place.innerHTML = figures.map((f, k) => `<figure data-figure="${k}"><figcaption></figcaption></figure>`).join("");
  document.body.append(place);
  const begin = performance.now(), drawing = lceFigures((numbers) => numbers);
  await drawing.draw(place.querySelectorAll("figure"), figures);
  while (drawing.plots.length < 5 || !drawing.plots.every(drawing.inked)) await new Promise(requestAnimationFrame);
  const took = (performance.now() - begin) / 1000;
  drawing.clear();
  place.remove();
  return took;
}"""
SLIDE = """async (steps) => {
  const figures = document.querySelector(".hand .figures");
  const slider = document.querySelector(".sliders input[type=range]");
  const took = [];
  for (let i = 0; i < steps; i++) {
    const before = figures.dataset.replaced ?? "0", begin = performance.now();
    slider.stepUp();
    slider.dispatchEvent(new Event("input"));
    while ((figures.dataset.replaced ?? "0") === before && performance.now() - begin < 5000) {
      await new Promise((next) => setTimeout(next, 1));
    }
    await new Promise(requestAnimationFrame);
    took.push(performance.now() - begin);
    await new Promise((next) => setTimeout(next, 150));
  }
  return took;
}"""


def _live(page: Page, folder: Path, live_s: float) -> Rows:
    """A long experiment with the page open on it, begun again where on a loaded machine the interlock ended it."""
    folder.mkdir()
    save_model(STRIP, folder / "model.yaml")
    with Served(page, folder) as served:
        page.get_by_role("tab", name="Bench").click()
        page.get_by_label("Protocol").fill(f"hold:power=0.6,hold={2.0 * (live_s + HEAT_UP_S):.0f}")
        under_way = page.get_by_label("progress of the job")
        runs, moments, memory = 0, [], []
        while not moments or moments[-1] < HEAT_UP_S + live_s:
            if not under_way.is_visible():
                page.get_by_role("button", name="Run on the simulated bench").click()
                expect(page.get_by_text(re.compile(r"T \d+\.\d+ °C"))).to_be_visible(timeout=60_000)
                runs += 1
            page.wait_for_timeout(1e3 * LOOK_S)
            moments.append(len(moments) * LOOK_S + LOOK_S)
            memory.append(served.memory_mb())
        page.get_by_role("button", name="Stop").click()
        expect(page.get_by_text("was stopped")).to_be_visible(timeout=60_000)
    warm = np.array(moments) > HEAT_UP_S
    slope = np.polyfit(np.array(moments)[warm], np.array(memory)[warm], 1)[0] * 3600.0
    told = f"{memory[-1]:.0f} MB, {slope:+.0f} MB an hour"
    what = f"memory of the server, {live_s / 60.0:.0f} min of live view, {runs} run{'s' if runs > 1 else ''}"
    return [(what, told, "500 MB after an hour")]


def record(path: Path, power: np.ndarray, seed: int, camera: int = 10) -> None:
    """A CSV of the strip at 100 Hz, its temperature at every ``camera``-th sample."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(power.size) / 100.0
    made = simulate(STRIP, time_s, power)
    temperature = made.measured_temperature_k - KELVIN + 0.06 * rng.standard_normal(time_s.size)
    displacement = made.measured_displacement_m + 4e-6 * rng.standard_normal(time_s.size)
    rows = [
        f"{t:.2f},{p:.4f},{f'{k:.3f}' if i % camera == 0 else ''},{d:.8f}"
        for i, (t, p, k, d) in enumerate(zip(time_s, power, temperature, displacement, strict=True))
    ]
    path.write_text("\n".join(["time_s,power_w,temperature_c,displacement_m", *rows]) + "\n", encoding="utf-8")
