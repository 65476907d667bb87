# SPDX-License-Identifier: Apache-2.0
"""The first minutes of somebody with measurements of his own: from files that are dropped on the page to a figure.

Nothing is there but an empty folder. Tables are dropped on the page, one run is held out, a model is fitted, what it
lacks is found and added, the error falls, and a figure is taken away. With LCE_SCREENSHOTS set to a folder, pictures
are kept there.
"""

import base64
import os
import re
from pathlib import Path

import numpy as np
import pytest
from chromium import Page, expect, needs_chromium
from test_workbench_in_chromium import JOB_MS, drawn, record, served, shown, tab

pytestmark = [pytest.mark.alone, needs_chromium]

DROP = """([name, content]) => {
    const bytes = Uint8Array.from(atob(content), (c) => c.charCodeAt(0));
    const files = new DataTransfer();
    files.items.add(new File([bytes], name));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: files, bubbles: true, cancelable: true }));
}"""


def picture(page: Page, name: str) -> None:
    """What a user sees without scrolling, below the head, which shows the folder."""
    if folder := os.environ.get("LCE_SCREENSHOTS"):
        page.screenshot(path=f"{folder}/{name}.png", clip={"x": 0, "y": 50, "width": 1280, "height": 850})


def drop(page: Page, file: Path) -> None:
    """Drop a file on the page."""
    page.evaluate(DROP, [file.name, base64.b64encode(file.read_bytes()).decode()])


def test_from_dropped_files_to_a_figure(tmp_path: Path) -> None:
    t = np.arange(0.0, 40.0, 0.01)
    desk = tmp_path / "desk"
    desk.mkdir()
    record(desk / "pulse.csv", np.where((t > 1.0) & (t < 16.0), 2.3, 0.0), 1)
    record(desk / "stairs.csv", np.select([t < 10.0, t < 18.0, t < 26.0], [1.0, 2.2, 1.2], 0.0), 2)
    record(desk / "foreign.csv", np.select([t < 7.0, t < 14.0, t < 24.0], [2.4, 0.5, 2.0], 0.0), 3)
    foreign = (desk / "foreign.csv").read_text()
    head = "Time [s];Laser [W];IR camera [degC];Height [m]"
    (desk / "foreign.csv").write_text(head + "\n" + foreign.partition("\n")[2].replace(",", ";").replace(".", ","))
    (tmp_path / "strip").mkdir()
    with served(tmp_path / "strip") as (address, _), shown(address) as page:
        for name in ("pulse", "stairs"):
            drop(page, desk / f"{name}.csv")
            expect(page.get_by_role("radiogroup", name=f"use of runs/{name}.csv")).to_be_visible(timeout=20_000)
        drop(page, desk / "foreign.csv")
        expect(page.get_by_role("row", name="IR camera")).to_contain_text("temperature", timeout=20_000)
        picture(page, "1-import")
        page.get_by_role("button", name="Import", exact=True).click()
        use = page.get_by_role("radiogroup", name="use of runs/foreign.csv")
        use.get_by_role("radio", name="hold out").click()
        expect(use.get_by_role("radio", name="hold out")).to_be_checked()
        picture(page, "2-runs")

        tab(page, "Add")
        page.get_by_role("button", name="Fit a model").click()
        expect(page.get_by_text("model 1: lumped + equilibrium fitted").first).to_be_visible(timeout=JOB_MS)

        tab(page, "Compare")
        expect(page.get_by_text("of the squared error of d").first).to_be_visible(timeout=JOB_MS)
        drawn(page, "hysteresis loop")
        picture(page, "3-compare")

        tab(page, "Diagnose")
        page.get_by_role("button", name="Diagnose", exact=True).click()
        expect(page.get_by_label("the answer")).to_contain_text("creep is missing", timeout=JOB_MS)
        expect(page.get_by_label("the answer")).to_contain_text("confirmed on foreign")
        picture(page, "4-diagnose")
        page.get_by_role("button", name="Add creep").click()
        expect(page.get_by_text("model 2: creep added to model 1")).to_be_visible(timeout=JOB_MS)
        drawn(page, "RMS error of displacement")
        picture(page, "5-add")

        tab(page, "Compare")
        displacement = page.locator("figcaption", has_text=re.compile(r"^displacement\sd(?! of)"))
        figure = page.locator("figure:visible").filter(has=displacement)
        with page.expect_download() as download:
            figure.get_by_role("button", name="PDF").first.click()
        assert Path(download.value.path()).read_bytes().startswith(b"%PDF")
