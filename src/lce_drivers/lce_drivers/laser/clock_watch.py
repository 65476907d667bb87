# SPDX-License-Identifier: Apache-2.0
"""Whether a node's ticks come as they should: its clock runs, its process is not held up."""

from typing import Final

QUIET_CHECKS: Final = 2
AHEAD_S: Final = 0.005
"""How far a stamp may lie in the future [s]: the clocks of one bench agree at least so well."""


class ClockWatch:
    """Notices that a node's clock stands still or was set back, from checks that a steady clock times.

    Timers follow the node's clock: were it set back an hour, the laser would shine for an hour. One check without a
    tick since the last means nothing: after a machine that stood still, a late check may be followed at once by the
    next, before the next tick. QUIET_CHECKS of them in a row mean a clock that stopped.
    """

    def __init__(self) -> None:
        self._ticks = -1
        self._quiet = 0

    def stopped(self, ticks: int) -> bool:
        """One check: whether the clock stopped; ``ticks`` is the number of ticks until now."""
        self._quiet = self._quiet + 1 if ticks == self._ticks else 0
        self._ticks = ticks
        return self._quiet >= QUIET_CHECKS


class StallWatch:
    """Notices what nobody watched with the light on: a process that was held up, a clock that was set.

    A process that is stopped, swapped out or starved cannot end the light. When it goes on it must not continue either:
    nobody watched the strip, and the device's watchdog may have darkened it meanwhile. A clock that is set makes every
    age wrong, and a slew limit and a waveform jump with it.
    """

    def __init__(self, limit_s: float) -> None:
        """``limit_s`` [s] : longest time between two ticks of which the first one left the light on, and step of the
        clock between them.
        """
        self._limit_s = limit_s
        self._last: tuple[float, float] | None = None

    def tick(self, steady_s: float, now_s: float, lit: bool) -> str | None:
        """One tick at ``steady_s`` [s] of a steady clock and ``now_s`` [s] of the node's; the fault, or None.

        ``lit`` : the light is on until now.
        """
        before, self._last = self._last, (steady_s, now_s)
        if before is None or not lit:
            return None
        gap_s = steady_s - before[0]
        step_s = now_s - before[1] - gap_s
        if gap_s > self._limit_s:
            return f"the laser node stood still for {gap_s:.2f} s with the light on"
        if abs(step_s) > self._limit_s:
            return f"the clock was set {'forward' if step_s > 0.0 else 'back'} by {abs(step_s):.2f} s with the light on"
        return None
