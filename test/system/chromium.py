# SPDX-License-Identifier: Apache-2.0
"""What tests of pages need: Playwright, axe, and the Chromium of this machine.

Importing this module skips the importing test file where Playwright or axe is missing, unless CI=true.
"""

import os
import shutil
import sys
from pathlib import Path

import pytest

if os.environ.get("CI") != "true":
    for name in ("playwright", "axe_playwright_python"):
        pytest.importorskip(name, reason=f"{name} is not installed: it is in requirements/venv.in, not in ubuntu.txt")

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect, sync_playwright

__all__ = ["CHROMIUM", "FLAGS", "Axe", "Browser", "Page", "expect", "needs_chromium", "sync_playwright"]

NAMES = ("chromium", "chromium-browser", "google-chrome")
OF_PLAYWRIGHT = sorted(map(str, Path(sys.prefix, "browsers").glob("chromium-*/chrome-linux*/chrome")))
"""Where tools/test_extras.sh puts one if there is no system package."""
CHROMIUM = next(filter(None, [*map(shutil.which, NAMES), *OF_PLAYWRIGHT]), None)
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic"]

needs_chromium = pytest.mark.usefixtures("chromium")
"""Without a Chromium such a test is skipped, or fails under CI=true."""
