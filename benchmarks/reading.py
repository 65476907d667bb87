# SPDX-License-Identifier: Apache-2.0
"""Reading a long CSV run, each time in a process of its own: its time and its peak of memory."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE
from lce_data.run_csv import write_run_csv

ROWS = 3_600_000
BAR_S, BAR_MB = 3.0, 400.0
PROGRAM = """
import re, sys, time
begin = time.perf_counter()
from lce_data.read_runs import read_run
run = read_run(sys.argv[1])
seconds = time.perf_counter() - begin
(peak_kb,) = re.findall(r"VmHWM:\\s+(\\d+) kB", open("/proc/self/status").read())
print(seconds, int(peak_kb) / 1024.0)
"""


def measure() -> list[str]:
    """Ten hours at 100 Hz, with a camera at 10 Hz and with every cell filled."""
    rng = np.random.default_rng(0)
    time_s = 0.01 * np.arange(ROWS)
    load = os.getloadavg()[0]
    lines = [
        f"## Reading a CSV of {ROWS / 1e6:.1f} million rows",
        "",
        f"Imports included. Load average before it began: {load:.1f}.",
        "",
        "| temperature | file | time, best of 3 | bar | peak memory | bar |",
        "|---|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for name, every in (("at 10 Hz", 10), ("in every row", 1)):
            temperature = 300.0 + rng.standard_normal(ROWS)
            temperature[np.arange(ROWS) % every != 0] = np.nan
            values = {
                POWER: np.where(np.sin(0.1 * time_s) > 0.0, 1.5, 0.0),
                TEMPERATURE: temperature,
                DISPLACEMENT: 1e-3 * rng.standard_normal(ROWS),
            }
            file = Path(folder) / "run.csv"
            write_run_csv(file, time_s, values)
            size = file.stat().st_size / 1e6
            seconds, megabytes = zip(*(_read(file) for _ in range(3)), strict=True)
            lines.append(
                f"| {name} | {size:.0f} MB | **{min(seconds):.1f} s** | {BAR_S:g} s | **{max(megabytes):.0f} MB** "
                f"| {BAR_MB:g} MB |"
            )
    return [*lines, ""]


def _read(file: Path) -> tuple[float, float]:
    """Time [s] with the imports, and the peak of the resident memory [MB]."""
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(file)], capture_output=True, text=True, check=True)
    seconds, megabytes = map(float, done.stdout.split())
    return seconds, megabytes
