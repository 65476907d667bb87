# SPDX-License-Identifier: Apache-2.0
"""Files of the version before the schemas: they read with the values that the readers of that version gave.

`old_files/pulse` is what ``lce run pulse:amp=0.4,th=1,rest=1 --fast --seed 3`` recorded, `old_files/run.csv` is what
``lce simulate`` wrote.
"""

import shutil
from pathlib import Path

import pytest
import yaml

from lce_data import experiment_file
from lce_data.bag import metadata
from lce_data.bag.message_types import message_type
from lce_data.bag.reader import read_numbers
from lce_data.bag.repair import repair
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE, Channel
from lce_data.read_runs import read_run

OLD = Path(__file__).parent / "old_files"
SERIES = {
    "pulse": {
        POWER: (306, 3.05, 0.0, 1.8999506529926642, 175.26426729377445, 466.65),
        TEMPERATURE: (31, 2.99, 301.09, 304.05, 9390.88, 46.2),
        DISPLACEMENT: (306, 3.05, -7e-06, 4.5e-05, 5.3e-05, 466.65),
    },
    "run.csv": {
        POWER: (202, 2.01, 0.8, 0.8, 90.0, 203.01),
        TEMPERATURE: (202, 2.01, 301.126522, 302.536339, 60985.139406, 203.01),
        DISPLACEMENT: (202, 2.01, 4.974554071e-06, 2.39758405e-05, 0.003065342691429, 203.01),
    },
}
"""Samples, last time, first, largest and summed value, summed time [SI]."""
TOPICS = {
    "/lce/displacement": (306, 1.01, 775.71, 5.3e-05),
    "/lce/laser/power": (307, 1.01, 779.77, 175.26426729377445),
    "/lce/laser/power_command": (301, 1.01, 755.51, 175.26426729377442),
    "/lce/sim/displacement": (306, 1.01, 775.71, 7.252598934937254e-05),
    "/lce/sim/temperature": (306, 1.01, 775.71, 9126.86314192558),
    "/lce/temperature": (31, 1.04, 78.44, 923.23),
}
"""Messages, first and summed log time [s], summed number [recorded unit]."""


@pytest.mark.parametrize(("name", "expected"), SERIES.items())
def test_a_run_has_the_same_values(name: str, expected: dict[Channel, tuple[float, ...]]) -> None:
    run = read_run(OLD / name)
    assert set(run.series) == set(expected)
    for channel, numbers in expected.items():
        time_s, value = run.series[channel].time_s, run.series[channel].value
        found = (time_s.size, time_s[-1], value[0], value.max(), value.sum(), time_s.sum())
        assert found == pytest.approx(numbers, rel=1e-12, abs=1e-15)


def test_the_data_have_the_same_hash() -> None:
    assert read_run(OLD / "pulse").sha256 == "79f004ad74b3390cef50c5a516b23bf534059959f13b16ce7994a5070c6e75ad"
    assert read_run(OLD / "run.csv").sha256 == "eefe917b460681851612e75af783f658df61b31516afeab7ad4e1a913de12cd3"


def test_every_topic_has_the_same_numbers_at_the_same_log_times() -> None:
    found = {
        topic: (time_s.size, time_s[0], time_s.sum(), value.sum())
        for topic, (time_s, value) in read_numbers(OLD / "pulse").items()
    }
    assert found == {topic: pytest.approx(numbers, rel=1e-12, abs=1e-15) for topic, numbers in TOPICS.items()}


def test_the_experiment_says_the_same_and_is_written_as_it_was(tmp_path: Path) -> None:
    file = OLD / "pulse" / experiment_file.FILE_NAME
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    about = read_run(OLD / "pulse").experiment
    assert (about.protocol, about.mode, about.plant, about.seed, about.outcome) == (
        "pulse:amp=0.4,th=1,rest=1",
        "fast",
        "simulated",
        3,
        "complete",
    )
    assert (about.conditions.strip_length_m, about.conditions.ambient_temperature_c) == (0.01, 28.0)
    assert experiment_file.content_of(about) == content
    experiment_file.write(tmp_path, about)
    assert (tmp_path / experiment_file.FILE_NAME).read_bytes() == file.read_bytes()


def test_metadata_and_type_hashes_are_written_as_they_were(tmp_path: Path) -> None:
    found = metadata.read(OLD / "pulse")
    assert found.is_finished
    metadata.write(tmp_path, found)
    assert (tmp_path / metadata.FILE_NAME).read_bytes() == (OLD / "pulse" / metadata.FILE_NAME).read_bytes()
    for topic in (counted.topic_metadata for counted in found.topics_with_message_count):
        assert message_type(topic.type).hash == topic.type_description_hash


def test_a_whole_old_bag_is_left_alone_and_a_cut_one_repaired(tmp_path: Path) -> None:
    bag = tmp_path / "pulse"
    shutil.copytree(OLD / "pulse", bag)
    assert repair(bag).original is None
    file = bag / "recording.mcap"
    file.write_bytes(file.read_bytes()[:100_000])
    done = repair(bag)
    assert done.original is not None and done.messages > 0
    assert metadata.read(bag).custom_data == {"lce_state": "repaired"}
