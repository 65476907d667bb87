# SPDX-License-Identifier: Apache-2.0
"""Which power of a stream of commands may reach the strip."""

import math
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from lce_ros.timed_value import TimedValue


class PowerOutput(Protocol):
    """A laser that takes a power; a device that does not answer raises OSError."""

    @property
    def max_power_w(self) -> float:
        """The most that the device can give [W]."""

    def write(self, power_w: float) -> None:
        """Set the optical power [W]."""

    def close(self) -> None:
        """Set zero power and let go of the device."""


class State(Enum):
    """Why the power has its present value."""

    WAITING = "no command yet: zero power"
    FOLLOWING = "following the command"
    LIMITED = "the command is above max_power_w: limited"
    SLEWING = "rising at the slew limit"
    STALE = "the command is stale: zero power"
    INVALID = "the command is not a power (NaN, infinite or negative): zero power"


@dataclass(frozen=True, slots=True)
class PowerLimits:
    """Limits of the laser.

    Parameters
    ----------
    max_power_w : [W].
    command_timeout_s : maximum age of a command [s].
    slew_w_per_s : fastest rise [W/s]; 0: not limited.
    """

    max_power_w: float
    command_timeout_s: float = 0.1
    slew_w_per_s: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (("max_power_w", self.max_power_w), ("slew_w_per_s", self.slew_w_per_s)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name}: {value:g} is not within [0, inf)")
        if not (math.isfinite(self.command_timeout_s) and self.command_timeout_s > 0.0):
            raise ValueError(f"command_timeout_s: {self.command_timeout_s:g} s is not within (0, inf)")


class PowerGuard:
    """Turns commands into a safe power.

    c is the newest command published strictly before the tick, a its age::

        p = 0                                 no command, a > command_timeout_s, or c not finite or negative
        p = min(c, max_power_w, p' + slew_w_per_s * dt)   otherwise; p' is the power dt ago

    So p is always finite and within [0, max_power_w]. Only the rise is slewed: a fall is the safe direction
    and happens at once. Time is an argument; ``state`` says why the last power was what it was.
    """

    def __init__(self, limits: PowerLimits) -> None:
        self.limits = limits
        self.state = State.WAITING
        self.invalid_commands = 0
        self._commands: TimedValue[float] = TimedValue()
        self._power_w = 0.0
        self._applied_s = math.inf

    def command(self, power_w: float, t_s: float) -> None:
        """Take in a command [W] published at ``t_s`` [s]."""
        if not _is_power(power_w):
            self.invalid_commands += 1
        self._commands.put(power_w, t_s)

    def power_w(self, tick_s: float, now_s: float) -> float:
        """Power [W] for the tick at ``tick_s``; ``now_s`` [s] is later if the tick comes late."""
        command = self._commands.get(tick_s)
        wanted, self.state = self._wanted(command, self._commands.age(now_s))
        ceiling = self._ceiling_w(max(0.0, now_s - self._applied_s))
        if wanted > ceiling:
            wanted, self.state = ceiling, State.SLEWING
        self._power_w, self._applied_s = wanted, now_s
        return wanted

    @property
    def commanded(self) -> bool:
        """Whether the last power came from a fresh command; a command of zero and an invalid one count too."""
        return self.state not in (State.WAITING, State.STALE)

    def cut(self, now_s: float) -> float:
        """Override the last power with zero [W], and return it; a later rise begins there."""
        self._power_w, self._applied_s = 0.0, now_s
        return 0.0

    def _wanted(self, command: float | None, age_s: float) -> tuple[float, State]:
        if command is None:
            return 0.0, State.WAITING
        if not _is_power(command):
            return 0.0, State.INVALID
        if not age_s <= self.limits.command_timeout_s + 1e-9:
            return 0.0, State.STALE
        if command > self.limits.max_power_w:
            return self.limits.max_power_w, State.LIMITED
        return command, State.FOLLOWING

    def _ceiling_w(self, dt_s: float) -> float:
        if self.limits.slew_w_per_s == 0.0:
            return self.limits.max_power_w
        return min(self.limits.max_power_w, self._power_w + self.limits.slew_w_per_s * dt_s)


def _is_power(power_w: float) -> bool:
    return math.isfinite(power_w) and power_w >= 0.0
