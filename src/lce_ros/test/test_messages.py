# SPDX-License-Identifier: Apache-2.0
from lce_data.bag.reader import NUMBERS
from lce_data.channels import CHANNELS
from lce_ros.messages import KINDS


def test_nodes_and_bags_know_the_same_types_of_message_and_those_of_every_channel() -> None:
    assert set(KINDS) == set(NUMBERS)
    assert {channel.message for channel in CHANNELS} <= set(KINDS)
