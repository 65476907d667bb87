# SPDX-License-Identifier: Apache-2.0
"""The site of the documents: built without a warning, complete without a network, searchable from a folder."""

import os
import re
import subprocess
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

import pytest
from chromium import CHROMIUM, FLAGS, needs_chromium
from playwright.sync_api import Page, expect, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
LOADED = {
    "script": "src",
    "link": "href",
    "img": "src",
    "iframe": "src",
    "source": "src",
    "video": "src",
    "object": "data",
}
"""The attribute by which a tag makes a browser load something."""
WIDE = (
    "index",
    "reference/commands",
    "reference/parameters",
    "explanation/physics",
    "results/gallery",
    "reference/api",
)

pytestmark = [
    pytest.mark.timeout(400),
    pytest.mark.skipif(
        not (ROOT / ".venv" / ".lce-docs").exists() and os.environ.get("CI") != "true",
        reason="the tools of the site are not installed: make docs",
    ),
]


class Loads(HTMLParser):
    """The addresses that a page makes a browser load."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        values = dict(attributes)
        if tag in LOADED and values.get("rel") not in ("canonical", "next", "prev"):
            self.addresses.append(values.get(LOADED[tag]) or "")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [str(ROOT / "tools" / "docs.sh"), "--site-dir", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=380, check=False)
    assert done.returncode == 0 and "WARNING" not in done.stdout, done.stdout + done.stderr
    return folder


@pytest.fixture
def page(site: Path) -> Iterator[Page]:
    """A browser that opens the site as a folder; a page that fails, or asks anything else, fails the test."""
    complaints: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda r: complaints.append(r.url) if r.url.startswith("http") else None)
        yield page
        browser.close()
    assert complaints == []


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    assert len(pages) > 60
    for page in pages:
        outside = [a for a in Loads(page.read_text(encoding="utf-8")).addresses if re.match(r"(https?:)?//", a)]
        assert outside == [], page.relative_to(site)
    for style in site.rglob("*.css"):
        assert not re.search(r"(@import|url\()\s*[\"']?(https?:)?//", style.read_text(encoding="utf-8")), style


@needs_chromium
def test_a_search_in_the_folder_finds_a_page(site: Path, page: Page) -> None:
    page.goto((site / "index.html").as_uri())
    page.get_by_placeholder("Search").click()
    page.get_by_placeholder("Search").press_sequentially("anti-windup")
    expect(page.locator(".md-search-result__link").first).to_have_attribute(
        "href", re.compile("control"), timeout=20_000
    )


@needs_chromium
@pytest.mark.parametrize("width", [390, 800, 1400])
def test_pages_fit_the_screen(site: Path, page: Page, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    for name in WIDE:
        page.goto((site / f"{name}.html").as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= width, name


def test_formulas_are_drawn_without_a_script(site: Path) -> None:
    physics = (site / "explanation" / "physics.html").read_text(encoding="utf-8")
    assert physics.count("<math") > 50 and "\\frac" not in physics


def test_the_reference_is_that_of_the_code(site: Path) -> None:
    found = {
        "commands": "--predictive-check",
        "parameters": "max_power_w",
        "topics": "laser/power_command",
        "json": "strength_by_run",
        "api": "add_effect",
        "formats": "strip_length_m",
        "licences": "Apache-2.0",
    }
    for name, words in found.items():
        assert words in (site / "reference" / f"{name}.html").read_text(encoding="utf-8"), name


def test_every_dependency_states_its_licence(site: Path) -> None:
    text = (site / "reference" / "licences.html").read_text(encoding="utf-8")
    assert "not stated" not in text and "UNKNOWN" not in text
