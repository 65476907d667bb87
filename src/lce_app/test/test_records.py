# SPDX-License-Identifier: Apache-2.0
"""What jobs leave for the page: files of the version before read, and what is wrong with one is named."""

import json
from pathlib import Path

import pytest

from lce_app.workbench.records import DesignRecord, read_diagnosis, read_record
from lce_data.errors import LceError
from lce_report import Table

TABLE = {"title": "RMS error, × noise", "head": ["runs", "sensor", "as given"], "rows": [["prbs", "T", "0.93"]]}
CANDIDATE = {
    "effect": "creep",
    "stage": "strain",
    "meaning": "part of the contraction arrives late",
    "standing": "missing",
    "reason": "worth having",
    "evidence": 12.0,
    "p_value": 1e-9,
    "visibility": 0.4,
    "expected_strength": 0.1,
    "predicted_fall": 0.3,
    "actual_fall": 0.9,
    "aliases": ["phase_kinetics"],
    "settings": {"creep.share": 0.1, "creep.tau_v": 8},
    "shown": True,
}
LEADING = {
    "effect": "creep",
    "meaning": "part of the contraction arrives late",
    "outcome": "missing: worth having",
    "picture": {"sensor": "displacement", "run": "pulse", "time_s": [0, 1], "residual": [0.5, None], "change": [0, 0]},
    "strength": {"name": "creep.share", "unit": "1", "null": 0, "runs": ["pulse"], "by_run": [[0.1, 0.01]]},
}
OLD = {"verdict": "missing", "sentences": ["creep is missing."], "added": ["creep"], "candidates": []}
"""As the version before wrote it."""
TABLES = {
    "errors": TABLE,
    "steps": None,
    "varies": None,
    "strengths": None,
    "ranking": TABLE,
    "not_tried": "",
    "evidence": TABLE,
}
DIAGNOSIS = {**OLD, "candidates": [CANDIDATE], "tables": TABLES, "leading": [LEADING]}
DESIGN = {
    "between": ["creep", "phase_kinetics"],
    "protocol": "prbs",
    "separation": 7.5,
    "hottest_c": 99.0,
    "command": "lce design",
}
"""As the version before wrote it: without sentences."""


def _file(folder: Path, content: object) -> Path:
    file = folder / "record.json"
    file.write_text(json.dumps(content), encoding="utf-8")
    return file


def test_a_diagnosis_reads(tmp_path: Path) -> None:
    found = read_diagnosis(_file(tmp_path, DIAGNOSIS))
    assert found.verdict == "missing" and found.candidates[0].settings == {"creep.share": 0.1, "creep.tau_v": 8.0}
    assert isinstance(found.tables.errors, Table) and found.tables.errors.rows[0][2] == "0.93"
    assert found.leading[0].strength is not None and found.leading[0].strength.by_run == [(0.1, 0.01)]


def test_a_diagnosis_of_an_earlier_version_is_to_be_made_again(tmp_path: Path) -> None:
    with pytest.raises(LceError, match=r"record\.json: made by an earlier version: diagnose again$"):
        read_diagnosis(_file(tmp_path, OLD))


def test_a_design_of_the_version_before_reads(tmp_path: Path) -> None:
    assert read_record(_file(tmp_path, DESIGN), DesignRecord).sentences == ()


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ({}, "not what the workbench wrote: verdict is missing"),
        ({**DIAGNOSIS, "verdict": "perhaps"}, "verdict is 'perhaps', which is not a value that is known here"),
        ([], "the content is a list; it must be keys with values"),
    ],
)
def test_another_file_is_named_with_what_is_wrong(content: object, told: str, tmp_path: Path) -> None:
    file = _file(tmp_path, content)
    with pytest.raises(LceError) as caught:
        read_diagnosis(file)
    assert str(caught.value).startswith(f"{file}: ") and told in str(caught.value)
    assert str(caught.value).endswith("delete it, and begin that job again")


def test_a_file_that_is_no_json_is_named(tmp_path: Path) -> None:
    (tmp_path / "record.json").write_text("{")
    with pytest.raises(LceError, match=r"record\.json: not a JSON file; delete it"):
        read_record(tmp_path / "record.json", DesignRecord)
