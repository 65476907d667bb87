# SPDX-License-Identifier: Apache-2.0
"""experiment.yaml: what is known is checked, what is not known is kept."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from lce_data import experiment_file
from lce_data.errors import LceError
from lce_data.experiment_file import Conditions, Experiment, content_of, describe, experiment_of


def _file(folder: Path, content: Any) -> Path:
    path = folder / experiment_file.FILE_NAME
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


def test_a_description_comes_back_as_it_was_written(tmp_path: Path) -> None:
    model = tmp_path / "m.yaml"
    model.write_text("x", encoding="utf-8")
    before = describe("pulse", "fast", "simulated", 3, model, {"creep.tau": 3.0}, {"strip_length_m": 0.01, "hall": "B"})
    experiment_file.write(tmp_path, before)
    experiment_file.update(tmp_path, outcome="complete", messages={"/lce/temperature": 9})
    after = experiment_file.read(tmp_path / experiment_file.FILE_NAME)
    assert after == before.with_entries(outcome="complete", messages={"/lce/temperature": 9})
    assert after.model is not None and after.model.set == {"creep.tau": 3.0}
    assert after.conditions == Conditions(strip_length_m=0.01, other={"hall": "B"})


def test_the_file_has_the_keys_that_other_programs_read() -> None:
    content = content_of(describe("pulse", "fast", "simulated", 3, None, {}, {}))
    assert list(content) == ["format", "protocol", "mode", "plant", "seed", "model", "conditions", "software"]
    assert content["format"] == "lce-experiment-1"
    assert content["model"] == {"file": None, "sha256": None, "set": {}}


def test_what_launch_files_leave_out_may_be_missing(tmp_path: Path) -> None:
    about = experiment_of({"mode": "launch", "protocol": "pulse", "plant": "hardware"})
    assert about.model is None and about.seed is None and about.conditions.strip_length_m is None
    assert content_of(about) == {"protocol": "pulse", "mode": "launch", "plant": "hardware", "conditions": {}}
    (tmp_path / experiment_file.FILE_NAME).write_text("")
    assert experiment_file.beside(tmp_path) == Experiment()


def test_unknown_keys_are_kept(tmp_path: Path) -> None:
    content = {
        "operator": "Wu",
        "other": {"a": [1, 2]},
        7: "seven",
        "conditions": {"specimen": 12, "day": "2026-11-22", "load_n": 1, "humidity": 0.4, "other": "x"},
        "model": {"file": "m.yaml", "author": "me"},
    }
    _file(tmp_path, content)
    experiment_file.update(tmp_path, outcome="interrupted")
    written = yaml.safe_load((tmp_path / experiment_file.FILE_NAME).read_text(encoding="utf-8"))
    assert written["operator"] == "Wu" and written["other"] == {"a": [1, 2]} and written["7"] == "seven"
    assert written["conditions"] == content["conditions"]
    assert written["model"]["author"] == "me" and written["outcome"] == "interrupted"


def test_the_file_of_a_bag_stands_in_its_folder_or_beside_it(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    bag.mkdir()
    (tmp_path / "bag.experiment.yaml").write_text("protocol: beside\n")
    assert experiment_file.beside(bag).protocol == experiment_file.beside(bag / "one.mcap").protocol == "beside"
    _file(bag, {"protocol": "inside"})
    assert experiment_file.beside(bag).protocol == experiment_file.beside(bag / "one.mcap").protocol == "inside"


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("pulse", "the content is not keys with values"),
        ([1], "the content is not keys with values"),
        ({"conditions": "warm"}, "conditions is 'warm'; it must be keys with values"),
        ({"conditions": {"strip_length_m": "long"}}, "conditions.strip_length_m is 'long'; it must be a number"),
        ({"conditions": {"strip_length_m": 0}}, "conditions.strip_length_m is 0; it must be a number > 0.0"),
        ({"conditions": {"ambient_c": [20]}}, "conditions.ambient_c is a list; it must be a number"),
        ({"conditions": {"specimen": 1.5}}, "conditions.specimen is 1.5; it must be a whole number or text"),
        ({"seed": "three"}, "seed is 'three'; it must be a whole number"),
        ({"protocol": {"pulse": 1}}, "protocol is keys with values; it must be text"),
        ({"model": {"set": {"a.b": 1, "creep.tau": "x"}}}, "model.set.creep.tau is 'x'; it must be a number"),
        ({"model": "m.yaml"}, "model is 'm.yaml'; it must be keys with values"),
        ({"lost": {"/lce/temperature": "few"}}, "lost./lce/temperature is 'few'; it must be a whole number"),
    ],
)
def test_a_wrong_type_is_named(content: Any, told: str, tmp_path: Path) -> None:
    path = _file(tmp_path, content)
    with pytest.raises(LceError) as caught:
        experiment_file.beside(tmp_path)
    assert str(caught.value) == f"{path}: {told}"
