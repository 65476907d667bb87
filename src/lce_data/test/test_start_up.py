# SPDX-License-Identifier: Apache-2.0
"""Reading a CSV, or refusing a file that is not there, loads no library that only other formats need."""

import subprocess
import sys

REFUSE = """
import sys
from lce_data.errors import LceError
from lce_data.read_runs import read_run
import lce_data.bag.message_types, lce_data.waveforms
try:
    read_run("nosuch.csv")
except LceError:
    print(*sorted(name for name in ("mcap", "polars", "rosbags", "scipy", "yaml", "pandas") if name in sys.modules))
"""


def test_a_missing_file_is_refused_without_the_libraries_of_bags() -> None:
    done = subprocess.run([sys.executable, "-c", REFUSE], capture_output=True, text=True, check=True)
    assert done.stdout == "\n"
