# SPDX-License-Identifier: Apache-2.0
"""`make pictures`: the pictures of the documents, taken of the reports that `make demo` wrote.

To be run whenever reports look otherwise; the pictures are committed.
"""

import argparse
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

from PIL import Image
from playwright.sync_api import Locator, Page, sync_playwright

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
WIDTH = 1280
"""Of the page, in pixels; the pictures are as wide."""
MARGIN = 16

Ends = Callable[[Page], tuple[Locator | None, Locator]]
"""The first and the last element of a picture; None is the top of the report."""


def section(page: Page, heading: str) -> Locator:
    """The section of a report with that heading."""
    return page.locator("section").filter(has=page.locator("h2", has_text=heading)).first


def figure(page: Page, heading: str, number: int) -> Locator:
    """A figure of a section, counted from 0."""
    return section(page, heading).locator("figure").nth(number)


PARTS: dict[str, tuple[str, Ends]] = {
    "where-the-error-sits": ("compare", lambda p: (None, section(p, "Where the error sits"))),
    "a-run-in-the-report": ("compare", lambda p: (section(p, "Run pulse"), figure(p, "Run pulse", 7))),
    "candidates": ("diagnose", lambda p: (None, section(p, "The candidates").locator("table").first)),
    "leading-candidates": ("diagnose", lambda p: (figure(p, "The candidates", 0), figure(p, "The candidates", 1))),
    "before-and-after": ("add", lambda p: (section(p, "The errors"), section(p, "The errors"))),
    "residuals-before-and-after": ("add", lambda p: (section(p, "pulse"), section(p, "pulse"))),
    "the-error-falls": ("add", lambda p: (figure(p, "held out", 3), figure(p, "held out", 3))),
}
"""By the name of the picture: the report, and what of it."""


def main() -> int:
    """Take every picture again."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--demo", type=Path, default=ROOT / "demo", help="folder of the reports")
    args = parser.parse_args()
    if not (args.demo / "add.html").exists():
        print(f"pictures: {args.demo}/add.html is not there; make demo writes it", file=sys.stderr)
        return 1
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDTH, "height": 900}, color_scheme="light")
        for name, (report, ends) in PARTS.items():
            page.goto((args.demo / f"{report}.html").resolve().as_uri())
            take(page, PICTURES / f"{name}.png", *ends(page))
        browser.close()
    return 0


def take(page: Page, file: Path, first: Locator | None, last: Locator) -> None:
    """A picture of a report from one element to another, over its whole width."""
    height = page.evaluate("document.documentElement.scrollHeight")
    page.set_viewport_size({"width": WIDTH, "height": height})  # figures are drawn once they are in view
    page.wait_for_function("[...document.querySelectorAll('figure canvas')].every((c) => c.width > 0)")
    page.wait_for_timeout(500)
    start, end = first and first.bounding_box(), last.bounding_box()
    assert end is not None
    top = max(start["y"] - MARGIN, 0.0) if start else 0.0
    clip = {"x": 0.0, "y": top, "width": float(WIDTH), "height": end["y"] + end["height"] + MARGIN - top}
    page.screenshot(path=file, clip=clip, full_page=True)
    page.set_viewport_size({"width": WIDTH, "height": 900})
    kept(file)


def kept(file: Path) -> None:
    """Make a picture small enough to be committed: figures have few colours."""
    Image.open(file).convert("RGB").quantize(128).save(file, optimize=True)
    print(file.relative_to(ROOT))


if __name__ == "__main__":
    sys.exit(main())
