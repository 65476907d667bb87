# SPDX-License-Identifier: Apache-2.0
"""Optional inputs of a run: out of files and bags, into files, and one number of the conditions in their place."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from lce_data.bag.reader import read_bag
from lce_data.channels import AMBIENT, INPUTS, LOAD, POWER, TEMPERATURE, Channel, named_input
from lce_data.errors import LceError
from lce_data.experiment_file import experiment_of
from lce_data.read_runs import read_run
from lce_data.run import Run, Series
from lce_data.run_csv import write_run_csv
from lce_data.topics import RECORDED
from lce_data.units import KELVIN

HUMIDITY = named_input("input_humidity")
TIME_S = 0.1 * np.arange(12)
STORE = get_typestore(Stores.ROS2_JAZZY)
each = pytest.mark.parametrize("channel", [*INPUTS, HUMIDITY], ids=lambda c: c.name)


def _bag(path: Path, topics: dict[str, tuple[str, np.ndarray]]) -> Path:
    """A bag with messages at TIME_S after 100 s; by topic their type and values [recorded unit]."""
    header, stamp = STORE.types["std_msgs/msg/Header"], STORE.types["builtin_interfaces/msg/Time"]
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, (kind, values) in topics.items():
            connection = writer.add_connection(topic, kind, typestore=STORE)
            for seconds, value in zip(100.0 + TIME_S, values, strict=False):
                at = round(seconds * 1e9)
                if kind == "std_msgs/msg/Float64":
                    message = STORE.types[kind](value)
                else:
                    message = STORE.types[kind](header(stamp(at // 10**9, at % 10**9), ""), value, 0.0)
                writer.write(connection, at, STORE.serialize_cdr(message, kind))
    return path


def _measured(channel: Channel, value: np.ndarray) -> dict[str, tuple[str, np.ndarray]]:
    """Topics of a run: power, temperature and an input [recorded unit]."""
    return {
        f"/lce/{c.topic}": (c.message, values)
        for c, values in ((POWER, np.ones(12)), (TEMPERATURE, np.full(12, 30.0)), (channel, value))
    }


@each
def test_an_input_is_read_as_it_was_written(channel: Channel, tmp_path: Path) -> None:
    value = channel.recorded.to_si(20.0 + np.arange(12.0))
    value[1:8] = np.nan
    write_run_csv(tmp_path / "run.csv", TIME_S, {POWER: np.ones(12), TEMPERATURE: np.full(12, 300.0), channel: value})
    header = (tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header == f"time_s,power_w,temperature_c,{channel.column}"
    run = read_run(tmp_path / "run.csv")
    assert list(run.inputs) == [channel]
    assert list(run.measured) == [TEMPERATURE]
    np.testing.assert_allclose(run.inputs[channel].time_s, TIME_S[~np.isnan(value)])
    np.testing.assert_allclose(run.inputs[channel].value, value[~np.isnan(value)])


@each
def test_an_input_comes_out_of_a_bag(channel: Channel, tmp_path: Path) -> None:
    run = read_run(_bag(tmp_path / "bag", _measured(channel, 20.0 + np.arange(5.0))))
    assert list(run.inputs) == [channel]
    np.testing.assert_allclose(run.inputs[channel].time_s, TIME_S[:5], atol=1e-6)
    np.testing.assert_allclose(run.inputs[channel].value, channel.recorded.to_si(20.0 + np.arange(5.0)))


def test_the_recorder_records_them() -> None:
    assert {channel.topic: channel.message for channel in INPUTS}.items() <= RECORDED.items()


def test_inputs_of_another_namespace_are_none_of_the_strip(tmp_path: Path) -> None:
    other = {
        "/computer/load": ("std_msgs/msg/Float64", np.ones(12)),
        "/computer/input/fan": ("std_msgs/msg/Float64", np.ones(12)),
    }
    recorded = read_bag(_bag(tmp_path / "bag", _measured(AMBIENT, np.full(12, 20.0)) | other))
    assert list(recorded) == [POWER, TEMPERATURE, AMBIENT]


def test_a_load_alone_is_nothing_to_compare_a_model_with(tmp_path: Path) -> None:
    write_run_csv(tmp_path / "run.csv", TIME_S, {POWER: np.ones(12), LOAD: np.ones(12)})
    with pytest.raises(LceError, match="neither temperature nor displacement"):
        read_run(tmp_path / "run.csv")


def test_an_ambient_in_kelvin_is_refused(tmp_path: Path) -> None:
    values = {POWER: np.ones(12), TEMPERATURE: np.full(12, 300.0), AMBIENT: np.full(12, 295.0 + KELVIN)}
    write_run_csv(tmp_path / "run.csv", TIME_S, values)
    with pytest.raises(LceError, match=r"ambient of 295 °C; is it in kelvin\?"):
        read_run(tmp_path / "run.csv")


def _told(**conditions: object) -> Run:
    return Run("run", {}, experiment=experiment_of({"conditions": conditions}))


@pytest.mark.parametrize(
    ("conditions", "channel", "value"),
    [
        ({"ambient_c": 21.0}, AMBIENT, 21.0 + KELVIN),
        ({"ambient_temperature_c": 28.0}, AMBIENT, 28.0 + KELVIN),
        ({"ambient_c": 21.0, "ambient_temperature_c": 28.0}, AMBIENT, 21.0 + KELVIN),
        ({"load_n": 0.05}, LOAD, 0.05),
        ({"input_humidity": 41}, HUMIDITY, 41.0),
    ],
)
def test_one_number_of_the_conditions_stands_for_a_series(
    conditions: dict[str, object], channel: Channel, value: float
) -> None:
    run = _told(**conditions)
    assert list(run.inputs) == [channel]
    assert run.inputs[channel].value == pytest.approx([value])
    measured = Series(TIME_S, np.linspace(1.0, 2.0, 12))
    assert run.with_series(channel, measured).inputs[channel] is measured


def test_a_run_of_which_nothing_is_told_has_no_inputs() -> None:
    assert not Run("run", {}).inputs
    assert not _told(input_humidity="dry", remark="load_n was not weighed").inputs


def test_conditions_of_a_csv_stand_in_a_file_beside_it(tmp_path: Path) -> None:
    write_run_csv(tmp_path / "run.csv", TIME_S, {POWER: np.ones(12), TEMPERATURE: np.full(12, 300.0)})
    (tmp_path / "run.yaml").write_text("conditions: {ambient_c: 19.5, load_n: 0.04}\n", encoding="utf-8")
    run = read_run(tmp_path / "run.csv")
    assert {c: s.value[0] for c, s in run.inputs.items()} == {AMBIENT: 19.5 + KELVIN, LOAD: 0.04}
