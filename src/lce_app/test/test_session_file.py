# SPDX-License-Identifier: Apache-2.0
"""The session file of the workbench: that of the version before reads, and what is wrong with one is named."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from lce_app.workbench.session import Kept, Session, folder_and_roles, load
from lce_data.errors import LceError

OLD = """\
format: lce-workbench-1
roles:
  a.csv: train
  later/größe: test
  b: 'off'
models:
- number: 1
  how: fitted to a.csv
  parent: null
  command: lce fit a.csv --out model.yaml
- number: 2
  how: with creep
  parent: 1
  command: lce add creep a.csv
current: 1
"""
"""As the version before the schema wrote it."""


def _file(folder: Path, text: str) -> Path:
    file = folder / "workbench" / "session.yaml"
    file.parent.mkdir()
    file.write_text(text, encoding="utf-8")
    return file


def test_the_file_of_the_version_before_is_read_and_written_as_it_was(tmp_path: Path) -> None:
    file = _file(tmp_path, OLD)
    session = load(tmp_path)
    assert session == Session(
        tmp_path,
        {"a.csv": "train", "later/größe": "test", "b": "off"},
        (
            Kept(1, "fitted to a.csv", None, "lce fit a.csv --out model.yaml"),
            Kept(2, "with creep", 1, "lce add creep a.csv"),
        ),
        1,
    )
    session.save()
    assert file.read_text(encoding="utf-8") == OLD


def test_a_folder_without_a_file_has_an_empty_session(tmp_path: Path) -> None:
    assert load(tmp_path) == Session(tmp_path, {})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"format": "lce-workbench-2"}, "format is 'lce-workbench-2', which is not a value that is known here"),
        ({"roles": {"a.csv": "train", "b": "learn"}}, "roles.b is 'learn', which is not a value that is known here"),
        ({"models": {}}, "models is keys with values; it must be a list"),
        ({"models": [{"number": "one", "how": "x"}]}, "models[0].number is 'one'; it must be a whole number"),
        ({"models": [{"number": 1}]}, "models[0].how is missing"),
        ({"models": [{"number": 1, "how": "x", "why": 3}]}, "models[0].why is not a key that is known here"),
        ({"current": "first"}, "current is 'first'; it must be a whole number"),
    ],
)
def test_a_wrong_value_is_named(change: dict[str, Any], told: str, tmp_path: Path) -> None:
    file = _file(tmp_path, yaml.safe_dump(yaml.safe_load(OLD) | change))
    with pytest.raises(LceError) as caught:
        load(tmp_path)
    assert str(caught.value) == f"{file}: no session of the workbench: {told}; move it away to begin anew"


def test_a_current_model_that_is_not_in_the_history_is_named(tmp_path: Path) -> None:
    _file(tmp_path, yaml.safe_dump(yaml.safe_load(OLD) | {"current": 7}))
    with pytest.raises(LceError, match=r"session\.yaml: current is 7, which is the number of no model"):
        load(tmp_path)


def test_one_folder_is_the_folder_of_the_page(tmp_path: Path) -> None:
    (tmp_path / "a.csv").touch()
    assert folder_and_roles([tmp_path]) == (tmp_path.resolve(), {})


def test_runs_that_are_named_are_learnt_from_and_the_others_left_aside(tmp_path: Path) -> None:
    (tmp_path / "later").mkdir()
    for name in ("a.csv", "b.csv", "later/c.csv"):
        (tmp_path / name).touch()
    named = [tmp_path / "a.csv", tmp_path / "later" / "c.csv"]
    assert folder_and_roles(named) == (
        tmp_path.resolve(),
        {"a.csv": "train", "b.csv": "off", "later/c.csv": "train"},
    )
    (tmp_path / "m.yaml").touch()
    with pytest.raises(LceError, match=r"m\.yaml: is no run"):
        folder_and_roles([*named, tmp_path / "m.yaml"])
