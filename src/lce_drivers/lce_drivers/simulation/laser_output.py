# SPDX-License-Identifier: Apache-2.0
"""The simulated laser."""

import math


class SimulatedOutput:
    """A PowerOutput for the simulated strip, which takes its power from the topic laser/power: nothing to write to."""

    max_power_w = math.inf

    def write(self, power_w: float) -> None:
        """Nothing to do."""

    def mismatch(self) -> str | None:
        """There is no device that could differ."""
        return None

    def close(self) -> None:
        """Nothing to let go of."""
