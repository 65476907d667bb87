# SPDX-License-Identifier: Apache-2.0
"""The measured heater runs of docs/results/heater.md as experiments, as `lce import` makes them there.

They were measured on a TCLab board and come from the folder data/ of github.com/dowlinglab/pyomo-doe (BSD-3-Clause),
where their names begin with `validation_experiment_env_2_`. Tests and `make heater` take them from beside the
repository: `find()` returns None where they are not there, and they skip. There is no displacement, so only the thermal
stage can be judged.

The drive of heater 1 is given in per cent of an unstated power. In the runs the column `power_w` holds that drive with
100 % = 1 "W": it is a relative power, so a gain fitted to it is in K per full drive, not in K/W. The temperature is
sensor 1's, rounded by the board to steps of 0.32 K. Heater 2 was off; sensor 2 is left out.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from lce_data.importing.read import read_foreign
from lce_data.importing.recording import Pick

REPOSITORY = Path(__file__).resolve().parents[1]
COLUMNS: Final = tuple(map(Pick.parse, ("time=Time:s", "power=Q1:%", "temperature=T1:degC")))
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


def convert_all(folder: Path, target: Path) -> dict[str, Path]:
    """Import RUNS out of `folder` into the folder `target`; the files by the run's name.

    Raises LceError if a file is not there or lacks a column, a number cannot be read, or its time does not increase.
    """
    return {name: read_foreign(folder / f"{name}.csv", COLUMNS).write(target, {}, overwrite=True) for name in RUNS}
