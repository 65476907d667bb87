# SPDX-License-Identifier: Apache-2.0
"""The Chromium of this machine, for tests of what a browser shows."""

import shutil
import sys
from pathlib import Path

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
OF_PLAYWRIGHT = sorted(map(str, Path(sys.prefix, "browsers").glob("chromium-*/chrome-linux*/chrome")))
"""Where tools/test_extras.sh puts one if there is no system package."""
CHROMIUM = next(filter(None, [*map(shutil.which, NAMES), *OF_PLAYWRIGHT]), None)
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic"]

needs_chromium = pytest.mark.usefixtures("chromium")
"""Without a Chromium such a test is skipped, or fails under CI=true."""
