# SPDX-License-Identifier: Apache-2.0
import pickle

import numpy as np
import pytest

from lce_data.channels import CHANNELS, DISPLACEMENT, POWER, SENSORS, TEMPERATURE, Channel, channel_named


@pytest.mark.parametrize("channel", CHANNELS)
def test_units_go_there_and_back(channel: Channel) -> None:
    values = np.array([0.001, 1.0, 300.0])
    for unit in (channel.recorded, channel.display):
        np.testing.assert_allclose(unit.to_si(unit.from_si(values)), values, rtol=1e-12, atol=1e-9)


def test_a_channel_is_the_same_object_behind_a_pickle() -> None:
    for channel in CHANNELS:
        assert pickle.loads(pickle.dumps(channel)) is channel
        assert channel_named(channel.name) is channel


def test_columns_of_the_contract() -> None:
    assert [c.column for c in CHANNELS] == ["power_w", "temperature_c", "displacement_m"]
    assert SENSORS == (TEMPERATURE, DISPLACEMENT)
    assert POWER.output is None


def test_every_sensor_follows_another_channel() -> None:
    assert [c.driven_by for c in CHANNELS] == [None, POWER, TEMPERATURE]
