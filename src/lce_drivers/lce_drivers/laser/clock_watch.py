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
    """Notices that a process was held up with the light on: stopped and continued, swapped out, starved.

    A stalled process cannot end the light. When it goes on it must not continue either: nobody watched the strip, and
    the device's watchdog may have darkened it meanwhile.
    """

    def __init__(self, limit_s: float) -> None:
        """``limit_s`` [s] : longest time between two ticks of which the first one left the light on."""
        self._limit_s = limit_s
        self._last_s: float | None = None

    def tick(self, steady_s: float, lit: bool) -> str | None:
        """One tick at ``steady_s`` [s] of a steady clock; the fault, or None. ``lit``: the light is on until now."""
        gap_s = 0.0 if self._last_s is None else steady_s - self._last_s
        self._last_s = steady_s
        return (
            f"the laser node stood still for {gap_s:.2f} s with the light on" if lit and gap_s > self._limit_s else None
        )
