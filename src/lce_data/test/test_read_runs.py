# SPDX-License-Identifier: Apache-2.0
"""Experiments in: from CSV files and bags to runs in SI units, and errors that name the file and the row."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lce_data.bag.message_types import OWN
from lce_data.channels import STAMPED_NUMBER
from lce_data.errors import LceError
from lce_data.read_runs import read_run, read_runs
from lce_data.units import KELVIN

HEADER = "time_s,power_w,temperature_c,displacement_m"
ROWS = [f"{10.0 + 0.1 * i:.1f},{0.5 * (i >= 3)},{25.0 + i},{1e-5 * i}" for i in range(12)]
STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(get_types_from_msg(OWN[STAMPED_NUMBER], STAMPED_NUMBER))
Messages = dict[str, tuple[str, list[tuple[float, float]]]]
"""By topic: type, and (time [s], value) of each message."""
BAG: Messages = {
    "/lce/laser/power": ("std_msgs/msg/Float64", [(100.0 + 0.01 * i, 0.5) for i in range(20)]),
    "/lce/temperature": ("sensor_msgs/msg/Temperature", [(100.0 + 0.1 * i, 25.0 + i) for i in range(8)]),
    "/lce/displacement": ("std_msgs/msg/Float64", [(100.0 + 0.01 * i, 1e-5 * i) for i in range(20)]),
    "/lce/sim/displacement": ("std_msgs/msg/Float64", [(100.0, 1.0)]),
}


def csv(folder: Path, rows: list[str], header: str = HEADER, name: str = "run") -> Path:
    path = folder / f"{name}.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def bag(path: Path, recorded: Messages) -> Path:
    """A rosbag2 folder; temperatures are logged every 0.1 s from 100.005 s on, whatever their stamps."""
    plain = STORE.types["std_msgs/msg/Float64"]
    header, stamp = STORE.types["std_msgs/msg/Header"], STORE.types["builtin_interfaces/msg/Time"]
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, (kind, series) in recorded.items():
            connection = writer.add_connection(topic, kind, typestore=STORE)
            for i, (seconds, value) in enumerate(series):
                log = at = round(seconds * 1e9)
                if kind.startswith("std"):
                    message = plain(value)
                else:
                    rest = [0.0] if kind.endswith("Temperature") else []
                    message = STORE.types[kind](header(stamp(at // 10**9, at % 10**9), "strip"), value, *rest)
                    log = 100_005_000_000 + 100_000_000 * i
                writer.write(connection, log, STORE.serialize_cdr(message, kind))
    return path


def test_a_csv_becomes_kelvin_and_seconds_since_the_first_power(tmp_path: Path) -> None:
    run = read_run(csv(tmp_path, ROWS))
    assert run.name == "run"
    assert run.power is not None and run.temperature is not None and run.displacement is not None
    assert run.power.time_s == pytest.approx(0.1 * np.arange(12))
    assert run.power.value == pytest.approx(0.5 * (np.arange(12) >= 3))
    assert run.temperature.value == pytest.approx(25.0 + KELVIN + np.arange(12))
    assert run.displacement.value == pytest.approx(1e-5 * np.arange(12))


def test_empty_cells_are_samples_that_a_sensor_does_not_have(tmp_path: Path) -> None:
    rows = [row if i % 2 == 0 else ",".join([*row.split(",")[:2], "", row.split(",")[3]]) for i, row in enumerate(ROWS)]
    rows += [f"{11.2 + 0.1 * i:.1f},0,{40 + i},0" for i in range(4)]
    run = read_run(csv(tmp_path, rows))
    assert run.power is not None and run.temperature is not None
    assert run.power.time_s.size == 16
    assert run.temperature.time_s == pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.3, 1.4, 1.5])


def test_what_was_not_measured_is_none(tmp_path: Path) -> None:
    loop = [",".join(row.split(",")[::2] + row.split(",")[3:]) for row in ROWS]
    run = read_run(csv(tmp_path, loop, "time_s,temperature_c,displacement_m"))
    assert run.power is None
    assert run.temperature is not None and run.temperature.time_s[0] == 0.0


def test_runs_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    for name in ("monday", "tuesday"):
        (tmp_path / name).mkdir()
    paths = [csv(tmp_path / "monday", ROWS), csv(tmp_path / "tuesday", ROWS), csv(tmp_path, ROWS, name="other")]
    runs = read_runs(paths)
    assert [r.name for r in runs] == ["monday/run", "tuesday/run", "other"]
    assert runs[0].sha256 == runs[1].sha256  # of the data, wherever they lie
    with pytest.raises(LceError, match=r"other\.csv: is given twice"):
        read_runs([*paths, paths[-1]])


def test_runs_of_one_name_in_folders_of_one_name_are_told_apart_too(tmp_path: Path) -> None:
    folders = [tmp_path / place for place in ("monday/runs", "tuesday/runs")]
    for folder in folders:
        folder.mkdir(parents=True)
    runs = read_runs([csv(folder, ROWS) for folder in folders])
    assert [r.name for r in runs] == ["monday/runs/run", "tuesday/runs/run"]


def _with(row: int, cell: int, text: str) -> Callable[[list[str]], list[str]]:
    def change(rows: list[str]) -> list[str]:
        cells = rows[row - 2].split(",")
        cells[cell] = text
        return [*rows[: row - 2], ",".join(cells), *rows[row - 1 :]]

    return change


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (_with(4, 2, "inf"), r"run\.csv, row 4: temperature_c is inf"),
        (_with(5, 3, "1,5e-3"), r"run\.csv, row 5: 5 cells under a header of 4; a decimal comma\?"),
        (_with(6, 0, "10.0"), r"run\.csv, row 6: time does not increase: 10 s after 10\.3 s"),
        (_with(7, 0, ""), r"run\.csv, row 7: time_s is empty"),
        (_with(8, 1, "half"), r"run\.csv, row 8: power_w is 'half', not a number"),
        (lambda rows: rows[:5], r"run\.csv: power has 5 samples; 8 are the least"),
    ],
)
def test_a_bad_row_is_named(change: Callable[[list[str]], list[str]], told: str, tmp_path: Path) -> None:
    with pytest.raises(LceError, match=told):
        read_run(csv(tmp_path, change(ROWS)))


def _column(cell: int, first: float) -> list[str]:
    """ROWS with another column that begins at ``first``."""
    cells = [row.split(",") for row in ROWS]
    return [",".join([*c[:cell], f"{first + 0.1 * i:g}", *c[cell + 1 :]]) for i, c in enumerate(cells)]


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (_column(1, -1.0), r"power of -1 W; a laser gives 0 W or more"),
        (_column(2, 300.0), r"temperature around 301 °C; is it in kelvin\? Subtract 273\.15"),
        (_column(2, -300.0), r"temperature of -300 °C; is it in kelvin\?"),
        (_column(3, 1.0), r"displacement of 2\.1 m; is it in millimetres\? Divide by 1000"),
    ],
)
def test_a_value_in_another_unit_is_refused_with_what_to_do(rows: list[str], told: str, tmp_path: Path) -> None:
    with pytest.raises(LceError, match=told):
        read_run(csv(tmp_path, rows))


def test_a_single_wild_temperature_is_no_mistaken_unit(tmp_path: Path) -> None:
    run = read_run(csv(tmp_path, _with(4, 2, "900")(ROWS)))
    assert run.temperature is not None and run.temperature.value.max() == 900.0 + KELVIN


@pytest.mark.parametrize(
    ("kept", "told"),
    [
        ((0, 1), "run.csv: neither temperature nor displacement: nothing to compare a model with"),
        ((0, 2), "run.csv: no laser power, and not both temperature and displacement: nothing to relate"),
    ],
)
def test_a_run_that_relates_nothing_is_refused(kept: tuple[int, ...], told: str, tmp_path: Path) -> None:
    header, *rows = [",".join(row.split(",")[i] for i in kept) for row in (HEADER, *ROWS)]
    with pytest.raises(LceError, match=told):
        read_run(csv(tmp_path, rows, header))


def test_a_bag_is_timed_by_stamps_and_read_whatever_its_namespace(tmp_path: Path) -> None:
    folder = bag(tmp_path / "pulse", BAG)
    (folder / "experiment.yaml").write_text(
        yaml.safe_dump({"protocol": "pulse", "conditions": {"strip_length_m": 0.02}})
    )
    run = read_run(folder)
    assert run.name == "pulse" and run.experiment.protocol == "pulse" and run.strip_length_m == 0.02
    assert run.power is not None and run.temperature is not None and run.displacement is not None
    assert run.power.time_s == pytest.approx(0.01 * np.arange(20))
    assert run.temperature.time_s == pytest.approx(0.1 * np.arange(8), abs=1e-6)  # not 5 ms later
    assert run.temperature.value[0] == pytest.approx(25.0 + KELVIN)
    assert run.displacement.value.max() == pytest.approx(19e-5)  # not that of sim/displacement
    (file,) = folder.glob("*.mcap")
    alone = read_run(file)
    assert alone.power is not None and np.array_equal(alone.power.value, run.power.value)


STAMPED: Messages = {
    "/lce/laser/power_stamped": (STAMPED_NUMBER, [(100.0 + 0.01 * i, 0.5) for i in range(20)]),
    "/lce/displacement_stamped": (STAMPED_NUMBER, [(100.004 + 0.01 * i, 2e-5 * i) for i in range(20)]),
}


@pytest.mark.parametrize("plain", [True, False])
def test_numbers_with_a_time_of_their_own_are_preferred(tmp_path: Path, plain: bool) -> None:
    beside = {topic: BAG[topic] for topic in ("/lce/laser/power", "/lce/displacement")} if plain else {}
    run = read_run(bag(tmp_path / "run", {"/lce/temperature": BAG["/lce/temperature"], **beside, **STAMPED}))
    assert run.power is not None and run.displacement is not None
    assert run.power.time_s == pytest.approx(0.01 * np.arange(20), abs=1e-6)
    assert run.displacement.time_s == pytest.approx(0.004 + 0.01 * np.arange(20), abs=1e-6)  # not when it was logged
    assert run.displacement.value == pytest.approx(2e-5 * np.arange(20))


def test_a_stamped_topic_of_another_type_is_left_alone(tmp_path: Path) -> None:
    other = {"/lce/displacement_stamped": BAG["/lce/temperature"]}
    run = read_run(bag(tmp_path / "run", BAG | other))
    assert run.displacement is not None and run.displacement.value.max() == pytest.approx(19e-5)


def test_of_two_messages_at_one_instant_the_last_one_holds(tmp_path: Path) -> None:
    kind, series = BAG["/lce/laser/power"]
    run = read_run(bag(tmp_path / "run", BAG | {"/lce/laser/power": (kind, [*series, (series[-1][0], 0.0)])}))
    assert run.power is not None
    assert run.power.time_s.size == 20 and run.power.value[-1] == 0.0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"/two/displacement": BAG["/lce/displacement"]}, r"several actuators in one bag \(/lce/, /two/\)"),
        ({"/lce/displacement": ("sensor_msgs/msg/Temperature", [(100.0, 25.0)])}, "is a sensor_msgs/msg/Temperature"),
        (
            {"/lce/temperature": (BAG["/lce/temperature"][0], [(101.0 - 0.1 * i, 25.0) for i in range(9)])},
            "time of temperature does not increase at its sample 2",
        ),
        (
            {"/lce/displacement": (BAG["/lce/displacement"][0], [(100.0 + i, float("nan")) for i in range(9)])},
            r"displacement is nan at 0\.000 s",
        ),
    ],
)
def test_a_bag_that_cannot_be_used_is_told_with_its_topic(change: Messages, told: str, tmp_path: Path) -> None:
    with pytest.raises(LceError, match=told):
        read_run(bag(tmp_path / "run", BAG | change))


def test_what_is_no_experiment_at_all(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("nothing")
    (tmp_path / "cut.mcap").write_bytes(b"\x89MCAP0\r\n")
    (tmp_path / "empty").mkdir()
    for name, told in (("notes.txt", "neither a rosbag2 folder"), ("cut.mcap", "lce repair"), ("empty", "lce repair")):
        with pytest.raises(LceError, match=told):
            read_run(tmp_path / name)


def test_channels_without_a_time_in_common_are_refused(tmp_path: Path) -> None:
    late = [(seconds - 100.0, value) for seconds, value in BAG["/lce/temperature"][1]]
    one = bag(tmp_path / "two_clocks", {**BAG, "/lce/temperature": ("sensor_msgs/msg/Temperature", late)})
    with pytest.raises(LceError, match=r"temperature was recorded from -100 to -99\.3 s, power from 0 to 0\.19 s"):
        read_run(one)


def test_stamps_that_nobody_set_are_no_times(tmp_path: Path) -> None:
    unset = [(0.0, value) for _, value in BAG["/lce/temperature"][1]]
    run = read_run(bag(tmp_path / "unset", {**BAG, "/lce/temperature": ("sensor_msgs/msg/Temperature", unset)}))
    assert run.temperature is not None
    np.testing.assert_allclose(run.temperature.time_s, 0.005 + 0.1 * np.arange(8), atol=1e-6)


def test_a_sensor_that_begins_where_the_power_has_ended_shares_its_time_with_the_other(tmp_path: Path) -> None:
    camera = [(100.0 + 0.1 * i, 25.0) for i in range(20)]
    late = [(100.5 + 0.01 * i, 1e-5) for i in range(20)]
    recorded = {
        **BAG,
        "/lce/temperature": ("sensor_msgs/msg/Temperature", camera),
        "/lce/displacement": ("std_msgs/msg/Float64", late),
    }
    assert read_run(bag(tmp_path / "late", recorded)).displacement is not None
