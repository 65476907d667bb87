# SPDX-License-Identifier: Apache-2.0
"""Whether the laser is armed, and the one latch of all its faults."""

from typing import Final

HEARD_S: Final = 0.1
"""How long the laser has to be known as not armed [s], so that every controller hears of it and begins anew."""


class Arming:
    """DISARMED, ARMED, or FAULT with its cause; light needs ARMED.

    ::

        DISARMED ── arm ────► ARMED       refused while light is commanded, and for HEARD_S
        ARMED ───── disarm ─► DISARMED
        either ──── latch ──► FAULT       the first cause is the one that is reported
        FAULT ───── reset ──► DISARMED    refused while a cause is there

    So light never comes back by itself: after a fault somebody resets, the commander goes to zero, somebody arms.

    Attributes
    ----------
    armed : whether light is allowed.
    fault : the cause of the fault; None without one.
    """

    def __init__(self, armed: bool = False) -> None:
        self.armed = armed
        self.fault: str | None = None

    def latch(self, fault: str | None) -> None:
        """Take in a fault; None changes nothing."""
        if fault is not None and self.fault is None:
            self.fault, self.armed = fault, False

    def reset(self, obstacle: str | None) -> str:
        """Clear the fault unless ``obstacle`` says what is still wrong; returns what happened, in words."""
        fault = self.fault
        if fault is None:
            return "there was no fault"
        if obstacle is not None:
            return f"not cleared, {obstacle}: {fault}"
        self.fault = None
        return f"cleared: {fault}; disarmed"

    def arm(self, commanded_w: float, told_s: float) -> str | None:
        """Arm; returns the reason if that is refused, else None.

        ``commanded_w`` [W] is 0 if nobody commands; ``told_s`` [s] is since when all could know that it is not armed.
        """
        if self.armed:
            return None
        if self.fault is not None:
            return f"there is a fault, call laser/reset first: {self.fault}"
        if not commanded_w <= 0.0:
            return f"{commanded_w:g} W are commanded; command zero first"
        if not told_s >= HEARD_S:
            return f"it was disarmed less than {HEARD_S:g} s ago; call again"
        self.armed = True
        return None

    def disarm(self) -> None:
        """Disarm; a fault stays."""
        self.armed = False
