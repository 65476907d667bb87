# SPDX-License-Identifier: Apache-2.0
"""The bench at one moment, as the page receives it several times a second."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from lce_app.workbench.live_series import Series, TopicFields
from lce_data.marker import Marker

PERIOD_S: Final = 1.0 / 15.0


@dataclass(frozen=True)
class Snapshot:
    """The latest values at ``time_s`` of the node's clock.

    values : by topic, in the unit of its message (°C, m, W); a topic that was silent is left out.
    conditions : level and message of nodes that reported since the last snapshot, by name.
    samples : of what is watched, since the last snapshot: times [s] as bytes of float64, and numbers as in the messages
        as bytes of float32.
    markers : that came since the last snapshot.
    topics : what can be watched, if that has changed.
    """

    time_s: float
    values: dict[str, float]
    conditions: dict[str, tuple[int, str]] = field(default_factory=dict)
    samples: dict[Series, tuple[bytes, bytes]] = field(default_factory=dict)
    markers: tuple[Marker, ...] = ()
    topics: tuple[TopicFields, ...] | None = None
