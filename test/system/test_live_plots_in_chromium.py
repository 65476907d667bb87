# SPDX-License-Identifier: Apache-2.0
"""The live view in a real browser: a plot is added, an event marked, and found again in the bag, with the specimen."""

import re
from pathlib import Path

import pytest
import yaml
from chromium import Axe, Page, expect, needs_chromium
from run_command import experiment, read, until
from test_workbench_in_chromium import JOB_MS, picture, served, shown, tab

from lce_data.read_runs import read_run

ODD = 'lamp <b>"on"</b> ä'
SPECIMEN = "A7 <img src=data:, onerror=window.ran=1>"
PLOT = "laser/power_stamped, sim/temperature"

pytestmark = [pytest.mark.alone, pytest.mark.timeout(300), needs_chromium]


def add_plot(page: Page, *topics: str) -> None:
    """Add a plot of topics that are found by typing."""
    page.get_by_role("button", name="Add a plot").click()
    field = page.get_by_label("Topics of the plot")
    for topic in topics:
        field.fill(topic.partition(" ")[0])
        expect(page.get_by_role("option").first).to_have_text(topic)  # before, the list moves under the mouse
        page.get_by_role("option", name=topic, exact=True).click()
        expect(page.locator(".q-chip", has_text=topic)).to_be_visible()
    field.press("Tab")
    page.get_by_role("button", name="Add the plot").click()


def order(page: Page) -> list[str]:
    """The plots as they stand on the page."""
    return page.locator("figure.live canvas").evaluate_all("(all) => all.map((c) => c.ariaLabel.split(' over ')[0])")


def test_an_event_is_marked_on_a_plot_and_found_in_the_bag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with served(tmp_path) as (address, _), shown(address) as page:
        tab(page, "Bench")
        page.get_by_label("Protocol").fill("hold:power=1.2,hold=90")
        page.get_by_label("Specimen").fill(SPECIMEN)
        page.get_by_label("Strip length [mm]").fill("12.5")
        page.get_by_label("Notes").fill("first line\nsecond: line")
        page.get_by_role("button", name="Run on the simulated bench").click()
        expect(page.get_by_text(" P 1.200 W")).to_be_visible(timeout=JOB_MS)

        add_plot(page, "laser/power_stamped [W]", "sim/temperature [°C]")
        plot = page.locator("figure.live", has_text=PLOT)
        legend = plot.locator(".u-legend")
        expect(legend).to_contain_text(re.compile(r"laser/power_stamped:?\s*1\.2 W"), timeout=20_000)
        expect(legend).to_contain_text(re.compile(r"sim/temperature:?\s*[\d.]+ °C"), timeout=20_000)
        page.get_by_role("button", name="Pause").focus()
        page.keyboard.press("m")
        page.keyboard.type(ODD)
        page.keyboard.press("Enter")
        marked = plot.locator(f".live-plot[data-markers='{ODD}']")
        expect(marked).to_be_visible()
        told = page.get_by_text(f"marked: {ODD}; it is in the recording")
        expect(told).to_be_visible()

        page.get_by_role("button", name=f"move up: {PLOT}").click()
        page.get_by_role("button", name=f"lower: {PLOT}").click()
        expect(page.locator("figure.live").nth(2)).to_contain_text(PLOT)
        expect(plot.locator(".u-wrap")).to_have_css("height", "120px")
        names = order(page)
        assert names[2] == PLOT and len(names) == 4
        for there in (0, 2):
            page.locator("figure.live", has_text=PLOT).locator("figcaption").drag_to(
                page.locator("figure.live").nth(there)
            )
            expect(page.locator("figure.live").nth(there)).to_contain_text(PLOT)
        assert order(page) == names
        picture(page, "8-live")
        expect(told).to_be_hidden(timeout=20_000)  # while it fades it has no contrast
        found = Axe().run(page)
        assert not found.violations_count, found.generate_report()
        for width in (800, 390):
            page.set_viewport_size({"width": width, "height": 900})
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            picture(page, f"8-live-{width}")

        page.reload()
        expect(marked).to_be_visible(timeout=20_000)
        assert order(page) == names, "the layout is that of before"
        expect(page.get_by_label("Specimen")).to_have_value(SPECIMEN)
        expect(page.get_by_label("Notes")).to_have_value("")
        page.get_by_role("button", name="Stop: laser to zero").click()
        tab(page, "Runs")
        expect(page.get_by_text(f"specimen {SPECIMEN}")).to_be_visible(timeout=30_000)
        assert page.evaluate("window.ran") is None

    (bag,) = tmp_path.glob("*_hold")
    assert until(lambda: experiment(bag).get("outcome"), "the end of the run") == "interrupted", experiment(bag)
    conditions = experiment(bag)["conditions"]
    assert conditions["specimen"] == SPECIMEN and conditions["notes"] == "first line\nsecond: line"
    assert conditions["strip_length_m"] == 0.0125 and re.fullmatch(r"\d{4}-\d\d-\d\d", conditions["day"])
    metadata = yaml.safe_load((bag / "metadata.yaml").read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
    assert metadata["custom_data"]["conditions.specimen"] == SPECIMEN
    assert [message.msg for message in read(bag)["/lce/marker"][1]] == [ODD]
    run = read_run(bag)
    assert [marker.text for marker in run.markers] == [ODD]
    assert run.power is not None and 0.0 < run.markers[0].time_s < run.power.time_s[-1]


def test_a_page_that_was_held_up_keeps_what_was_begun(tmp_path: Path) -> None:
    with served(tmp_path) as (address, _), shown(address) as page:
        tab(page, "Bench")
        page.get_by_role("button", name="Add a plot").click()
        page.get_by_label("Topics of the plot").fill("laser/power_stamped")
        page.evaluate("window.held = true; for (const end = Date.now() + 12000; Date.now() < end;);")
        page.wait_for_timeout(6000)
        assert page.evaluate("window.held"), "the page was loaded anew"
        page.get_by_role("option", name="laser/power_stamped [W]", exact=True).click()
        expect(page.locator(".q-chip", has_text="laser/power_stamped [W]")).to_be_visible()
