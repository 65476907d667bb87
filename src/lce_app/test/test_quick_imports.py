# SPDX-License-Identifier: Apache-2.0
"""The server starts without packages that it does not use, and leaves them to everybody else."""

import subprocess
import sys

import pytest

STARTED = """
import gc, sys
from importlib.util import find_spec
from lce_app.workbench.quick_imports import HTTP_CLIENTS, quick_imports
with quick_imports():
    import lce_app.workbench.server
assert gc.isenabled() and not sys.modules.keys() & set(HTTP_CLIENTS), sys.modules.keys() & set(HTTP_CLIENTS)
print([name for name in HTTP_CLIENTS if find_spec(name)])
import distributed, requests
"""


def test_the_server_needs_no_http_client_and_hides_none() -> None:
    pytest.importorskip("distributed")
    pytest.importorskip("requests")
    done = subprocess.run([sys.executable, "-c", STARTED], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "tornado" in done.stdout and "requests" in done.stdout
