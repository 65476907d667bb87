# SPDX-License-Identifier: Apache-2.0
"""What a user states of a run: text is kept as text, numbers are checked, and the bag says the same as the file."""

from pathlib import Path

import pytest
import yaml
from rosbags.rosbag2 import Reader

from lce_data import experiment_file
from lce_data.bag import metadata
from lce_data.bag.repair import repair
from lce_data.bag.writer import BagWriter
from lce_data.errors import LceError
from lce_data.experiment_file import Experiment, ModelUsed, custom_data, describe, with_provenance
from lce_data.given_conditions import check_conditions, parse_conditions
from lce_data.software import software

ODD = 'a "b": <i>{c}</i>\n- d\te \U0001f600 — *x &y !!z'


def test_numbers_are_numbers_and_names_stay_text() -> None:
    typed = {
        "specimen": " 007 ",
        "day": "2026",
        "notes": "",
        "ambient_c": "23.5",
        "strip_length_m": "1e-2",
        "hall": "B",
    }
    found = parse_conditions(typed)
    assert found == {"specimen": "007", "day": "2026", "ambient_c": 23.5, "strip_length_m": 0.01, "hall": "B"}


def test_texts_lose_control_characters_and_nothing_else() -> None:
    given = check_conditions({"specimen": "A\u0301\x00\x1b[31m\x7f", "notes": f"{ODD}\r\nlast", "hall": "\ud800"})
    assert given == {"specimen": "\u00c1[31m", "notes": f"{ODD}\nlast", "hall": "\\ud800"}


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ({"ambient_c": "-300"}, "ambient_c is -300 °C, below absolute zero"),
        ({"strip_length_m": "0"}, "strip_length_m is 0.0; it must be a number > 0.0"),
        ({"load_n": "heavy"}, "load_n is 'heavy'; it must be a number"),
        ({"load_n": "nan"}, "load_n is nan; it must be a finite number"),
        ({"notes": "x" * 4001}, "notes has 4001 characters; 4000 are the most"),
        ({"specimen": "x" * 201}, "specimen has 201 characters; 200 are the most"),
        ({"a b": "1"}, "'a b': a key is a word"),
        ({f"k{i}": "1" for i in range(51)}, "51 conditions; a run has 50 at most"),
    ],
)
def test_what_cannot_be_is_refused(typed: dict[str, str], said: str) -> None:
    with pytest.raises(LceError, match=said.replace("(", r"\(")):
        parse_conditions(typed)


def test_a_bag_says_what_the_file_beside_it_says(tmp_path: Path) -> None:
    given = {"specimen": "007", "notes": ODD, "strip_length_m": 0.05}
    about = describe("pulse", "fast", "simulated", 3, None, {"creep.tau": 3.0}, given)
    bag = BagWriter(tmp_path / "bag", custom_data(about))
    bag.add_topic("/lce/laser/power", "std_msgs/msg/Float64", ())
    bag.write("/lce/laser/power", 1, 1, b"\0\1\0\0" + bytes(8))
    bag.close()
    experiment_file.write(tmp_path / "bag", about)
    again = experiment_file.read(tmp_path / "bag" / experiment_file.FILE_NAME).conditions
    assert (again.specimen, again.other["notes"], again.strip_length_m) == ("007", ODD, 0.05)
    found = metadata.read(tmp_path / "bag").custom_data
    assert found is not None and all(isinstance(value, str) for value in found.values()), "rosbag2 reads text only"
    assert found["conditions.specimen"] == "007" and found["conditions.notes"] == ODD
    assert found["conditions.strip_length_m"] == "0.05" and found["model.set.creep.tau"] == "3.0"
    assert found["software.lce"] == software()["lce"] and found["lce_state"] == "finished"
    content = yaml.safe_load((tmp_path / "bag" / "metadata.yaml").read_text(encoding="utf-8"))
    assert content["rosbag2_bagfile_information"]["custom_data"] == found
    with Reader(tmp_path / "bag") as reader:
        assert reader.message_count == 1


def test_a_repaired_bag_still_says_which_specimen(tmp_path: Path) -> None:
    bag = BagWriter(tmp_path / "bag", {"conditions.specimen": "A7"})
    bag.add_topic("/lce/laser/power", "std_msgs/msg/Float64", ())
    bag.write("/lce/laser/power", 1, 1, b"\0\1\0\0" + bytes(8))
    bag.flush()
    left = {path: path.read_bytes() for path in bag.folder.iterdir()}
    bag.close()
    for path, content in left.items():  # as if it had been killed after the flush
        path.write_bytes(content)
    repair(bag.folder)
    assert metadata.read(tmp_path / "bag").custom_data == {"lce_state": "repaired", "conditions.specimen": "A7"}


def test_what_a_launch_file_cannot_know_is_added(tmp_path: Path) -> None:
    model = tmp_path / "m.yaml"
    model.write_text("x", encoding="utf-8")
    known = with_provenance(Experiment(plant="simulated", model=ModelUsed(file=str(model))))
    assert known.model is not None and known.model.sha256 is not None and known.model.sha256.startswith("2d711642")
    assert known.software == software()
    assert with_provenance(Experiment(plant="hardware", model=ModelUsed(file=""))).model is None
    gone = with_provenance(Experiment(model=ModelUsed(file="gone.yaml"))).model
    assert gone is not None and (gone.file, gone.sha256) == ("gone.yaml", None)
    given = Experiment(software={"lce": "9"})
    assert with_provenance(given).software == {"lce": "9"}
