# SPDX-License-Identifier: Apache-2.0
"""Which power of a stream of commands may reach the strip."""

import math
from dataclasses import dataclass
from enum import Enum
from typing import Final, Protocol

from lce_drivers.laser.clock_watch import AHEAD_S
from lce_ros.timed_value import TimedValue

UNUSED_S: Final = 60.0
"""How long an armed laser waits for its first command [s]."""


class PowerOutput(Protocol):
    """A laser that takes a power; a device that does not answer raises OSError."""

    @property
    def max_power_w(self) -> float:
        """The most that the device can give [W]."""

    def write(self, power_w: float) -> None:
        """Set the optical power [W]."""

    def mismatch(self) -> str | None:
        """In which way the device is not as it was left by the last ``write``; None if it is."""

    def close(self) -> None:
        """Set zero power, over a new connection if need be, and let go of the device."""


class State(Enum):
    """Why the power has its present value."""

    WAITING = "no command yet: zero power"
    FOLLOWING = "following the command"
    LIMITED = "the command is above max_power_w: limited"
    SLEWING = "rising at the slew limit"
    STALE = "the command is stale: zero power"
    INVALID = "the command is not a power (NaN, infinite or negative)"
    AHEAD = "the command is stamped in the future, the clocks differ"


@dataclass(frozen=True, slots=True)
class PowerLimits:
    """Limits of the laser.

    Parameters
    ----------
    max_power_w : [W].
    command_timeout_s : maximum age of a command [s].
    slew_w_per_s : fastest rise [W/s]; 0: not limited.
    fault_after_s : age of a command for light [s] at which the silence after it is a fault.
    """

    max_power_w: float
    command_timeout_s: float = 0.1
    slew_w_per_s: float = 0.0
    fault_after_s: float = 0.5

    def __post_init__(self) -> None:
        for name, value in (("max_power_w", self.max_power_w), ("slew_w_per_s", self.slew_w_per_s)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name}: {value:g} is not within [0, inf)")
        if not (math.isfinite(self.command_timeout_s) and self.command_timeout_s > 0.0):
            raise ValueError(f"command_timeout_s: {self.command_timeout_s:g} s is not within (0, inf)")
        if not (math.isfinite(self.fault_after_s) and self.fault_after_s > self.command_timeout_s):
            raise ValueError(f"fault_after_s: {self.fault_after_s:g} s is not above {self.command_timeout_s:g} s")


class PowerGuard:
    """Turns commands into a safe power.

    c is the newest command published strictly before the tick, a its age::

        p = 0                                 no command, a > command_timeout_s, or c not finite or negative
        p = min(c, max_power_w, p' + slew_w_per_s * dt)   otherwise; p' is the power dt ago
        fault                                 c > 0 and a > fault_after_s: who commands light has to say when it ends,
                                              or c not finite or negative

    So p is always finite and within [0, max_power_w]. Only the rise is slewed: a fall is the safe direction
    and happens at once. A command stamped more than AHEAD_S ahead counts as invalid: nobody knows its age.
    Time is an argument; ``state`` says why the last power was what it was.
    """

    def __init__(self, limits: PowerLimits) -> None:
        self.limits = limits
        self.state = State.WAITING
        self.invalid_commands = 0
        self._commands: TimedValue[float] = TimedValue()
        self._ahead = False
        self._command_w = 0.0
        self._power_w = 0.0
        self._applied_s = math.inf
        self._begun_s = math.inf

    def command(self, power_w: float, sent_s: float, now_s: float) -> str | None:
        """Take in at ``now_s`` [s] a command [W] published at ``sent_s`` [s]; returns what is wrong with it, or None.

        Another command may follow before the next tick, so the fault is not left to that.
        """
        self._ahead = sent_s > now_s + AHEAD_S
        self._commands.put(math.nan if self._ahead else power_w, min(sent_s, now_s))
        if not self._ahead and _is_power(power_w):
            return None
        self.invalid_commands += 1
        return (State.AHEAD if self._ahead else State.INVALID).value

    def power_w(self, tick_s: float, now_s: float) -> float:
        """Power [W] for the tick at ``tick_s``; ``now_s`` [s] is later if the tick comes late."""
        command = self._commands.get(tick_s)
        self._command_w = 0.0 if command is None or not _is_power(command) else command
        wanted, self.state = self._wanted(command, self._commands.age(now_s))
        ceiling = self._ceiling_w(max(0.0, now_s - self._applied_s))
        if wanted > ceiling:
            wanted, self.state = ceiling, State.SLEWING
        self._power_w, self._applied_s = wanted, now_s
        return wanted

    def heard(self, now_s: float) -> bool:
        """Whether somebody commands, be it slowly, or zero or nonsense; to be asked after ``power_w``.

        Silence that would be a fault with the light on is nobody; a timeout earlier it is not waited for any longer.
        """
        return self._commands.age(now_s) <= self.limits.fault_after_s - self.limits.command_timeout_s

    def fault(self, now_s: float) -> str | None:
        """Whether the commander fell silent with the light on, or talks nonsense; to be asked after ``power_w``."""
        if self.state in (State.INVALID, State.AHEAD):
            return self.state.value
        if self._command_w > 0.0 and self._commands.age(now_s) > self.limits.fault_after_s:
            return f"no command for {self.limits.fault_after_s:g} s after one of {self._command_w:g} W"
        return None

    def abandoned(self, now_s: float) -> bool:
        """Whether nobody commands: for as long as is a fault with the light on, or since ``forget`` for UNUSED_S."""
        age_s = self._commands.age(now_s)
        if age_s == math.inf:
            return now_s - self._begun_s > UNUSED_S
        return age_s > self.limits.fault_after_s

    def commanded_w(self, now_s: float) -> float:
        """The newest command at ``now_s`` [s], before all limits [W]; 0 if there is none.

        A slow commander still commands between two of its commands, for as long as its silence would be no fault.
        """
        command = self._commands.get(math.inf)
        lately = self._commands.age(now_s) <= self.limits.fault_after_s
        return command if lately and command is not None and _is_power(command) else 0.0

    def forget(self, now_s: float) -> None:
        """Forget at ``now_s`` [s] every command, as before the first one."""
        self._commands.clear()
        self._command_w, self.state, self._begun_s = 0.0, State.WAITING, now_s

    def cut(self, now_s: float) -> float:
        """Override the last power with zero [W], and return it; a later rise begins there."""
        self._power_w, self._applied_s = 0.0, now_s
        return 0.0

    def _wanted(self, command: float | None, age_s: float) -> tuple[float, State]:
        if command is None:
            return 0.0, State.WAITING
        if not _is_power(command):
            return 0.0, State.AHEAD if self._ahead else State.INVALID
        if not self._is_fresh(age_s):
            return 0.0, State.STALE
        if command > self.limits.max_power_w:
            return self.limits.max_power_w, State.LIMITED
        return command, State.FOLLOWING

    def _is_fresh(self, age_s: float) -> bool:
        return age_s <= self.limits.command_timeout_s + 1e-9

    def _ceiling_w(self, dt_s: float) -> float:
        if self.limits.slew_w_per_s == 0.0:
            return self.limits.max_power_w
        return min(self.limits.max_power_w, self._power_w + self.limits.slew_w_per_s * dt_s)


def _is_power(power_w: float) -> bool:
    return math.isfinite(power_w) and power_w >= 0.0
