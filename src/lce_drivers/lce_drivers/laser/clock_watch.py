# SPDX-License-Identifier: Apache-2.0
"""Whether the clock that a node ticks by still runs."""

from typing import Final

QUIET_CHECKS: Final = 2


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
