# SPDX-License-Identifier: Apache-2.0
"""The surroundings follow the measured temperature of the room: T_env(t) = T_env + s (T_room(t) - T_env).

With s = 1 the strip sees the room as measured; less where part of what it sees, such as its mount, keeps T_env, and
more where the thermometer lags. Where the room was not measured, T_env stays.

In the residual: an offset of T that goes with the measured room. ambient_drift goes straight with time.
"""

import math

from numba.extending import register_jitable

from lce_model.effects import Effect
from lce_model.terms import Parameter


@register_jitable
def _seen(ambient: float, room_temperature: float, share: float) -> float:
    return ambient if math.isnan(room_temperature) else ambient + share * (room_temperature - ambient)


def start(ambient: float, room_temperature: float, share: float) -> tuple[float, float]:
    """The room at the beginning."""
    return room_temperature, _seen(ambient, room_temperature, share)


def step(ambient: float, room_temperature: float, before: float, share: float) -> tuple[float, float]:
    """Temperature of the room [K], and of the surroundings, mean over the step [K]."""
    return room_temperature, _seen(ambient, 0.5 * (before + room_temperature), share)


EFFECT = Effect(
    name="room_temperature",
    title="room temperature as measured",
    meaning="the surroundings follow the temperature of the room",
    stage="surroundings",
    equation="T_env(t) = T_env + s (T_room(t) - T_env)",
    parameters=(Parameter("share", "1", 0.0, 0.0, 1.2, "share s of the room in it", "1 by definition of T_env"),),
    states=("before",),
    outputs=("ambient",),
    start=start,
    step=step,
    strength="share",
    typical=1.0,
    place=-1,
)
