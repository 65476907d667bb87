# SPDX-License-Identifier: Apache-2.0
"""The measured heater runs of docs/heater.md as experiments: python validation/heater.py SOURCE TARGET.

SOURCE is the folder data/ of github.com/dowlinglab/pyomo-doe (BSD-3-Clause), measured on a TCLab board. Tests and
`make heater` take it from beside the repository: `find()` returns None where it is not there, and they skip.
Only the thermal stage can be judged: there is no displacement.

The drive of heater 1 is given in per cent of an unstated power. In the files written here the column
`power_w` holds that drive with 100 % = 1 "W": it is a relative power, so a gain fitted to it is in K per full
drive, not in K/W. The temperature is sensor 1's, rounded by the board to steps of 0.32 K. Heater 2 was off;
sensor 2 is left out.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
FULL_DRIVE_PERCENT = 100.0
RUNS = (
    "sin_2_50_run_1",
    "sin_5_50_run_1",
    "sin_5_50_run_2",
    "step_50_run_1",
    "step_50_run_2",
    "step_50_run_3",
)


def find(repository: Path = REPOSITORY) -> Path | None:
    """The folder of the measured runs, or None where one of them is absent."""
    folder = repository.parent / "shared" / "data" / "heater"
    return folder if all((folder / f"{name}.csv").exists() for name in RUNS) else None


def convert(source: Path, target: Path) -> Path:
    """Write the measured run `source` (Time,T1,T2,Q1,Q2) as an experiment's CSV file `target`.

    Raises:
        ValueError: The source lacks a column, a number cannot be read, or its time does not increase.
    """
    rows: list[tuple[float, float, float]] = []
    with source.open(newline="") as file:
        table = csv.DictReader(file)
        missing = {"Time", "T1", "Q1"}.difference(table.fieldnames or ())
        if missing:
            raise ValueError(f"{source.name}: no column {', '.join(sorted(missing))}")
        for row in table:
            time_s, percent, celsius = float(row["Time"]), float(row["Q1"]), float(row["T1"])
            if rows and time_s <= rows[-1][0]:
                line = f"{source.name}, line {table.line_num}"
                raise ValueError(f"{line}: time {time_s} s after {rows[-1][0]} s")
            rows.append((time_s, percent / FULL_DRIVE_PERCENT, celsius))
    with target.open("w", newline="") as file:
        file.write("time_s,power_w,temperature_c\n")
        file.writelines(f"{time_s:.6f},{power:.9g},{celsius:.9g}\n" for time_s, power, celsius in rows)
    return target


def convert_all(folder: Path, target: Path) -> dict[str, Path]:
    """Convert RUNS out of `folder` into the existing folder `target`; the files by the run's name."""
    return {name: convert(folder / f"{name}.csv", target / f"{name}.csv") for name in RUNS}


if __name__ == "__main__":
    Path(sys.argv[2]).mkdir(parents=True, exist_ok=True)
    convert_all(Path(sys.argv[1]), Path(sys.argv[2]))
