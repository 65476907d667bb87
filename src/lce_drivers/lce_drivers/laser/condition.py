# SPDX-License-Identifier: Apache-2.0
"""The condition of the laser as its diagnosis tells it."""

from typing import Final

from lce_drivers.laser.arming import Arming
from lce_drivers.laser.power_guard import State
from lce_ros.health import FAULT, Level

LEVELS: Final = {
    State.WAITING: Level.OK,
    State.FOLLOWING: Level.OK,
    State.SLEWING: Level.OK,
    State.LIMITED: Level.WARN,
    State.STALE: Level.WARN,
    State.INVALID: Level.ERROR,
    State.AHEAD: Level.ERROR,
}


def condition(arming: Arming, state: State, wanted_w: float, cold: bool) -> tuple[Level, str]:
    """The condition of an active laser.

    Parameters
    ----------
    state : why the guard gave its last power.
    wanted_w : that power [W].
    cold : whether it is withheld for want of a fresh temperature.
    """
    if not arming.armed:
        level, words = dark(arming)
        return (Level.WARN if level is Level.OK and wanted_w > 0.0 else level), words
    if cold:
        return Level.WARN, "no fresh temperature: zero power"
    return LEVELS[state], state.value


def dark(arming: Arming) -> tuple[Level, str]:
    """The condition of a laser that is not armed, or not active."""
    if arming.fault is not None:
        return Level.ERROR, f"{FAULT}{arming.fault}; zero power until laser/reset and laser/arm"
    return Level.OK, "disarmed: zero power until laser/arm"
