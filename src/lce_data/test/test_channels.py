# SPDX-License-Identifier: Apache-2.0
import pickle

import numpy as np
import pytest

from lce_data.channels import (
    AMBIENT,
    CHANNELS,
    DISPLACEMENT,
    INPUTS,
    LOAD,
    POWER,
    SENSORS,
    TEMPERATURE,
    Channel,
    channel_named,
    channel_of_column,
    in_order,
    named_input,
)


@pytest.mark.parametrize("channel", CHANNELS)
def test_units_go_there_and_back(channel: Channel) -> None:
    values = np.array([0.001, 1.0, 300.0])
    for unit in (channel.recorded, channel.display):
        np.testing.assert_allclose(unit.to_si(unit.from_si(values)), values, rtol=1e-12, atol=1e-9)


def test_a_channel_is_the_same_object_behind_a_pickle() -> None:
    for channel in (*CHANNELS, named_input("input_humidity")):
        assert pickle.loads(pickle.dumps(channel)) is channel
        assert channel_named(channel.name) is channel


def test_columns_of_the_contract() -> None:
    assert [c.column for c in CHANNELS] == ["power_w", "temperature_c", "displacement_m", "ambient_c", "load_n"]
    assert [c.topic for c in INPUTS] == ["ambient_temperature", "load"]
    assert SENSORS == (TEMPERATURE, DISPLACEMENT)
    assert INPUTS == (AMBIENT, LOAD)
    assert POWER.output is None


def test_every_sensor_follows_another_channel_and_no_input_does() -> None:
    assert [c.driven_by for c in SENSORS] == [POWER, TEMPERATURE]
    assert all(c.driven_by is None and c.output is None for c in INPUTS)


def test_an_input_that_a_user_named_is_its_column_in_its_own_unit() -> None:
    humidity = channel_of_column("input_humidity")
    assert humidity is named_input("input_humidity")
    assert (humidity.column, humidity.sets, humidity.recorded.to_si(41.0)) == ("input_humidity", "input_humidity", 41.0)
    assert in_order([humidity, named_input("input_b"), LOAD, POWER]) == (POWER, LOAD, named_input("input_b"), humidity)
    for column in ("input_", "input_r h", "humidity", "time_s"):
        assert channel_of_column(column) is None
    with pytest.raises(KeyError):
        channel_named("humidity")
