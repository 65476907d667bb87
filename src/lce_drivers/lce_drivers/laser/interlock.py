# SPDX-License-Identifier: Apache-2.0
"""Whether the temperature of the strip allows light."""

import math
from dataclasses import dataclass, fields


@dataclass(frozen=True, slots=True)
class TemperatureLimits:
    """What a supervised strip may do.

    Parameters
    ----------
    max_temperature_k : highest temperature [K].
    max_jump_k : largest change between two readings [K].
    pause_after_s : age of the newest reading [s] at which the light pauses.
    fault_after_s : age of the newest reading [s] at which that is a fault.
    """

    max_temperature_k: float
    max_jump_k: float = 10.0
    pause_after_s: float = 0.2
    fault_after_s: float = 0.5

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value > 0.0):
                raise ValueError(f"{field.name}: {value:g} is not within (0, inf)")
        if not self.pause_after_s < self.fault_after_s:
            raise ValueError(f"pause_after_s: {self.pause_after_s:g} s is not below {self.fault_after_s:g} s")


class Interlock:
    """Allows light while the temperature is fresh and plausible.

    T is the newest reading, a its age, and T' the reading before it::

        paused    a > pause_after_s, or no reading: dark until the next one
        fault     a > fault_after_s while somebody commands the laser, even to zero
                  no reading yet, and light commanded for fault_after_s - pause_after_s
                  T is not a finite number, or T > max_temperature_k
                  |T - T'| > max_jump_k, no more than fault_after_s apart: no strip does that, a broken camera does

    A fault is latched: dark until ``reset``. Without commands no readings are needed. Readings stamped more than
    ``pause_after_s`` ahead are ignored.
    """

    def __init__(self, limits: TemperatureLimits) -> None:
        self.limits = limits
        self.fault: str | None = None
        self._last: tuple[float, float] | None = None
        self._paused_s: float | None = None

    def read(self, temperature_k: float, measured_s: float) -> None:
        """Take in a temperature [K] that was measured at ``measured_s`` [s]."""
        before = self._last
        self._last = (temperature_k, measured_s)
        self._latch(self._wrong_with(temperature_k))
        if before is None or not 0.0 <= measured_s - before[1] <= self.limits.fault_after_s:
            return
        jump_k = abs(temperature_k - before[0])
        if jump_k > self.limits.max_jump_k:
            self._latch(f"the temperature jumped by {jump_k:.1f} K between two readings")

    def permits(self, now_s: float, power_w: float | None) -> bool:
        """Whether ``power_w`` [W] may be applied at ``now_s`` [s]; None means that nobody commands."""
        fresh = self._is_fresh(now_s)
        wanted = power_w is not None and power_w > 0.0
        if fresh or not (wanted or (power_w is not None and self._last is not None)):
            self._paused_s = None
        elif self._paused_s is None:
            self._paused_s = now_s
        elif now_s - self._paused_s > self.limits.fault_after_s - self.limits.pause_after_s:
            self._latch(f"no temperature for {self.limits.fault_after_s:g} s")
        return self.fault is None and (fresh or not wanted)

    def reset(self, now_s: float) -> str | None:
        """Clear the fault; returns the reason if it cannot be cleared, else None."""
        if not self._is_fresh(now_s):
            return "there is no fresh temperature"
        assert self._last is not None
        wrong = self._wrong_with(self._last[0])
        if wrong is None:
            self.fault = self._paused_s = None
        return wrong

    def _wrong_with(self, temperature_k: float) -> str | None:
        if not math.isfinite(temperature_k):
            return f"the temperature is {temperature_k}"
        if temperature_k > self.limits.max_temperature_k:
            excess_k = temperature_k - self.limits.max_temperature_k
            return f"the strip is {excess_k:.1f} K above its highest temperature"
        return None

    def _is_fresh(self, now_s: float) -> bool:
        return self._last is not None and abs(now_s - self._last[1]) <= self.limits.pause_after_s

    def _latch(self, fault: str | None) -> None:
        self.fault = self.fault or fault
