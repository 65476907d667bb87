# SPDX-License-Identifier: Apache-2.0
"""Colours of channels that are shown beside each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE, Channel
from lce_report.blocks import Role

COLOURS: Final[Mapping[Channel, Role]] = {TEMPERATURE: "model", DISPLACEMENT: "residual", POWER: "input"}


def colour(channel: Channel) -> Role:
    """The colour of a channel; all others have that of a measurement."""
    return COLOURS.get(channel, "measured")
