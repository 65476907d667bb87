# SPDX-License-Identifier: Apache-2.0
import os

import pytest

MISSING = "no Chromium on this machine: tools/test_extras.sh gets one"


@pytest.fixture(scope="session")
def chromium() -> None:
    """Skip the test, or fail it under CI=true, if this machine has no Chromium."""
    from chromium import CHROMIUM

    if CHROMIUM is None:
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(MISSING)
