# SPDX-License-Identifier: Apache-2.0
"""The conditions of a CSV run: in comment lines in front of the header, and in a YAML file beside it."""

from pathlib import Path

import numpy as np
import pytest

from lce_data.channels import POWER, TEMPERATURE
from lce_data.errors import LceError
from lce_data.experiment_file import experiment_of
from lce_data.read_runs import read_run
from lce_data.run_csv import write_run_csv

ROWS = "\n".join(f"{0.1 * i:.1f},1,{25 + i}" for i in range(12))


def csv(folder: Path, head: str = "") -> Path:
    (folder / "run.csv").write_text(f"{head}time_s,power_w,temperature_c\n{ROWS}\n", encoding="utf-8")
    return folder / "run.csv"


def test_comment_lines_tell_conditions_and_free_notes(tmp_path: Path) -> None:
    head = "# Exported on Monday\n# ambient_c: 22.5\n# strip_length_m: 1e-2\n# specimen: A7\n# operator: Jo\n"
    run = read_run(csv(tmp_path, head))
    conditions = run.experiment.conditions
    assert (conditions.ambient_c, conditions.strip_length_m, conditions.specimen) == (22.5, 0.01, "A7")
    assert conditions.other == {"operator": "Jo"}
    assert run.strip_length_m == 0.01


def test_the_yaml_file_beside_it_goes_before_the_comments(tmp_path: Path) -> None:
    (tmp_path / "run.yaml").write_text("conditions:\n  ambient_c: 30.0\n  day: 2026-11-02\n", encoding="utf-8")
    conditions = read_run(csv(tmp_path, "# ambient_c: 22.5\n# load_n: 0.1\n")).experiment.conditions
    assert (conditions.ambient_c, conditions.load_n, conditions.day) == (30.0, 0.1, "2026-11-02")


def test_another_yaml_file_of_that_name_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "run.yaml").write_text("format: lce-model-1\nthermal: lumped\n", encoding="utf-8")
    assert read_run(csv(tmp_path)).experiment.conditions.ambient_c is None


def test_a_condition_that_is_no_number_is_named(tmp_path: Path) -> None:
    with pytest.raises(LceError, match=r"run\.csv: conditions\.ambient_c is 'warm'; it must be a number"):
        read_run(csv(tmp_path, "# ambient_c: warm\n"))
    (tmp_path / "run.yaml").write_text("conditions:\n  load_n: heavy\n", encoding="utf-8")
    with pytest.raises(LceError, match=r"run\.yaml: conditions\.load_n is 'heavy'; it must be a number"):
        read_run(csv(tmp_path))


def test_rows_are_counted_with_the_comments(tmp_path: Path) -> None:
    path = csv(tmp_path, "# a: 1\n# b: 2\n")
    path.write_text(path.read_text(encoding="utf-8").replace("0.3,1,28", "0.3,x,28"), encoding="utf-8")
    with pytest.raises(LceError, match=r"row 7: power_w is 'x'"):
        read_run(path)


def test_what_is_written_beside_a_run_is_read_with_it(tmp_path: Path) -> None:
    about = experiment_of({"conditions": {"ambient_c": 21.0, "specimen": "B", "note": "window open"}, "source": "x"})
    time_s = 0.1 * np.arange(12)
    write_run_csv(tmp_path / "run.csv", time_s, {POWER: np.ones(12), TEMPERATURE: 300.0 + time_s}, about)
    again = read_run(tmp_path / "run.csv").experiment
    assert again.conditions == about.conditions and again.other == {"source": "x"}


@pytest.mark.parametrize(
    ("header", "told"),
    [
        ("time_s,power_w,displacement_mm", r"'displacement_mm' is none of them.*: lce import .*run\.csv --out runs/"),
        ("time_ms,power_w,temperature_c", "'time_ms' is none of them"),
        ("power_w,temperature_c,displacement_m", "there is no time_s"),
        ("time_s,power_w,power_w", "power_w stands twice"),
    ],
)
def test_a_header_that_is_not_ours_is_refused_with_the_column_and_the_command(
    header: str, told: str, tmp_path: Path
) -> None:
    (tmp_path / "run.csv").write_text(f"{header}\n{ROWS}\n", encoding="utf-8")
    with pytest.raises(LceError, match=told):
        read_run(tmp_path / "run.csv")
