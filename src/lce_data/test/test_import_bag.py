# SPDX-License-Identifier: Apache-2.0
"""Chosen topics of a foreign bag made a run."""

from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lce_data.bag.message_types import OWN
from lce_data.channels import STAMPED_NUMBER
from lce_data.errors import LceError
from lce_data.importing.read import read_foreign
from lce_data.importing.recording import Pick
from lce_data.read_runs import read_run
from lce_data.units import KELVIN

STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(get_types_from_msg(OWN[STAMPED_NUMBER], STAMPED_NUMBER))
WRENCH, FLOAT32, TEMPERATURE = "geometry_msgs/msg/WrenchStamped", "std_msgs/msg/Float32", "sensor_msgs/msg/Temperature"


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A camera at 10 Hz whose stamps are 1 s before the log, and a heater and a force that other types hold."""
    kinds = STORE.types
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        topics = {"/heater/mw": FLOAT32, "/cam/temp": TEMPERATURE, "/cell/wrench": WRENCH}
        connections = {topic: writer.add_connection(topic, kind, typestore=STORE) for topic, kind in topics.items()}

        def write(topic: str, log_ns: int, message: object) -> None:
            writer.write(connections[topic], log_ns, STORE.serialize_cdr(message, topics[topic]))

        for i in range(40):
            log_ns = 2_000_000_000 + 100_000_000 * i
            stamp = kinds["builtin_interfaces/msg/Time"](*divmod(log_ns - 1_000_000_000, 10**9))
            header = kinds["std_msgs/msg/Header"](stamp, "")
            zero = kinds["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
            force = kinds["geometry_msgs/msg/Vector3"](0.0, 0.0, -0.001 * i)
            write("/heater/mw", log_ns, kinds[FLOAT32](1500.0))
            write("/cam/temp", log_ns, kinds[TEMPERATURE](header, 25.0 + i, 0.0))
            write("/cell/wrench", log_ns, kinds[WRENCH](header, kinds["geometry_msgs/msg/Wrench"](force, zero)))
    return tmp_path / "bag"


def picks(*texts: str) -> list[Pick]:
    return [Pick.parse(text) for text in texts]


def test_topics_and_fields_are_picked_with_their_units(bag: Path, tmp_path: Path) -> None:
    chosen = picks("power=/heater/mw:mW", "temperature=/cam/temp", "displacement=/cell/wrench.wrench.force.z:-m")
    recording = read_foreign(bag, (), chosen)
    assert recording.guesses == () and recording.left_out == ()
    run = read_run(recording.write(tmp_path / "runs", {}))
    assert run.power is not None and run.temperature is not None and run.displacement is not None
    np.testing.assert_allclose(run.power.value, 1.5, rtol=1e-6)
    np.testing.assert_allclose(run.temperature.value, 25.0 + KELVIN + np.arange(40), atol=1e-6)
    np.testing.assert_allclose(run.temperature.time_s, 0.1 * np.arange(40) - 1.0, atol=1e-6)  # by its stamps
    np.testing.assert_allclose(run.displacement.value, 0.001 * np.arange(40))


def test_a_unit_that_no_message_defines_is_a_guess(bag: Path) -> None:
    recording = read_foreign(bag, (), picks("power=/heater/mw", "temperature=/cam/temp"))
    assert [(s.source, s.unit.symbol, s.guessed) for s in recording.guesses] == [("/heater/mw", "mW", ("unit",))]
    assert recording.left_out == ("/cell/wrench",)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("temperature=/camera", r"no topic for temperature=/camera; it has /cam/temp \(sensor_msgs/msg/Temperature\)"),
        ("displacement=/cell/wrench", r"name a number of it: /cell/wrench\.wrench\.force\.x or \.wrench\.force\.y"),
        ("displacement=/cell/wrench.force", "name a number of it"),
    ],
)
def test_a_topic_that_holds_no_number_of_that_name_is_told(text: str, told: str, bag: Path) -> None:
    with pytest.raises(LceError, match=told):
        read_foreign(bag, (), picks(text))


def test_a_bag_without_a_topic_chosen_says_what_it_has(bag: Path) -> None:
    with pytest.raises(LceError, match=r"--topic QUANTITY=TOPIC says which topic holds what; it has /cam/temp"):
        read_foreign(bag)


def test_what_is_not_picked_comes_from_the_topics_of_the_bench(tmp_path: Path) -> None:
    plain = STORE.types["std_msgs/msg/Float64"]
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        names = ("/lce/laser/power", "/lce/displacement", "/lce/sim/displacement", "/box/heat")
        connections = [writer.add_connection(name, "std_msgs/msg/Float64", typestore=STORE) for name in names]
        for i in range(20):
            for connection in connections:
                message = STORE.serialize_cdr(plain(1e-3 * i), "std_msgs/msg/Float64")
                writer.write(connection, 10**9 + 10**8 * i, message)
    recording = read_foreign(tmp_path / "bag", (), picks("temperature=/box/heat:K"))
    assert [signal.source for signal in recording.signals] == ["/box/heat", "/lce/displacement", "/lce/laser/power"]
    assert recording.guesses == () and recording.left_out == ("/lce/sim/displacement",)
    recording = read_foreign(tmp_path / "bag", (), picks("temperature=/box/heat:K", "displacement="))
    assert [signal.quantity for signal in recording.signals] == ["temperature", "power"]


def test_of_the_topics_of_the_bench_those_with_stamps_are_taken(tmp_path: Path) -> None:
    kinds = STORE.types
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        plain = writer.add_connection("/lce/displacement", "std_msgs/msg/Float64", typestore=STORE)
        stamped = writer.add_connection("/lce/displacement_stamped", STAMPED_NUMBER, typestore=STORE)
        for i in range(20):
            log_ns = 2_000_000_000 + 10_000_000 * i + (i % 3) * 1_000_000
            stamp = kinds["builtin_interfaces/msg/Time"](1, 10_000_000 * i)
            message = kinds[STAMPED_NUMBER](kinds["std_msgs/msg/Header"](stamp, "strip"), 2e-5 * i)
            writer.write(
                plain, log_ns, STORE.serialize_cdr(kinds["std_msgs/msg/Float64"](1e-5), "std_msgs/msg/Float64")
            )
            writer.write(stamped, log_ns, STORE.serialize_cdr(message, STAMPED_NUMBER))
    (signal,) = read_foreign(tmp_path / "bag").signals
    assert (signal.quantity, signal.source) == ("displacement", "/lce/displacement_stamped")
    np.testing.assert_allclose(signal.time_s, 0.01 * np.arange(20), atol=1e-6)
    np.testing.assert_allclose(signal.value, 2e-5 * np.arange(20))
