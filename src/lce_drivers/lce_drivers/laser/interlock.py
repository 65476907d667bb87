# SPDX-License-Identifier: Apache-2.0
"""Whether the temperature of the strip allows light."""

import math
from dataclasses import dataclass, fields
from typing import Final

from lce_drivers.laser.clock_watch import AHEAD_S

MAY_BE_ZERO: Final = ("frozen_after_s",)


@dataclass(frozen=True, slots=True)
class TemperatureLimits:
    """What a supervised strip, and the camera that looks at it, may show.

    Parameters
    ----------
    max_temperature_k : highest temperature of the strip [K].
    min_temperature_k : lowest temperature of the camera's data sheet [K].
    max_jump_k : largest change between two readings [K].
    pause_after_s : age of the newest reading [s] at which the light pauses.
    fault_after_s : age of the newest reading [s] at which that is a fault.
    frozen_after_s : light during which the reading may stay the same bit for bit [s]; 0: for ever.
    """

    max_temperature_k: float
    min_temperature_k: float = 233.15
    max_jump_k: float = 10.0
    pause_after_s: float = 0.2
    fault_after_s: float = 0.5
    frozen_after_s: float = 1.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and (value > 0.0 or (field.name in MAY_BE_ZERO and value == 0.0))):
                raise ValueError(f"{field.name}: {value:g} is not within (0, inf)")
        if not self.pause_after_s < self.fault_after_s:
            raise ValueError(f"pause_after_s: {self.pause_after_s:g} s is not below {self.fault_after_s:g} s")
        if not self.min_temperature_k < self.max_temperature_k:
            raise ValueError(
                f"min_temperature_k: {self.min_temperature_k:g} K is not below {self.max_temperature_k:g} K"
            )


class Interlock:
    """Allows light while the temperature is fresh, and says what about it is a fault.

    T is the newest reading, a its age, and T' the reading before it::

        paused    a > pause_after_s, or no reading: dark until the next one
        fault     a > fault_after_s while somebody commands the laser, even to zero
                  no reading yet, and light wanted for fault_after_s - pause_after_s
                  T is not finite, T < min_temperature_k or T > max_temperature_k
                  T is stamped before T': nobody knows which of the two is the newer one
                  |T - T'| > max_jump_k, no more than fault_after_s apart: no strip does that, a broken camera does
                  T stayed the same bit for bit through frozen_after_s of light, be it in pieces: a camera that works
                  has noise

    Without commands no readings are needed. Readings stamped more than AHEAD_S ahead are ignored.
    """

    def __init__(self, limits: TemperatureLimits) -> None:
        self.limits = limits
        self._last: tuple[float, float] | None = None
        self._same_since_s = math.inf
        self._lit_s, self._judged_s = 0.0, math.inf
        self._paused_s: float | None = None
        self._ahead_s = 0.0

    def read(self, temperature_k: float, measured_s: float, now_s: float) -> str | None:
        """Take in at ``now_s`` [s] a temperature [K] measured at ``measured_s`` [s]; returns the fault, or None."""
        if measured_s > now_s + AHEAD_S:
            self._ahead_s = measured_s - now_s
            return None
        before, self._last, self._ahead_s = self._last, (temperature_k, measured_s), 0.0
        if before is not None and measured_s < before[1]:
            return f"a temperature is stamped {before[1] - measured_s:.3f} s before the one that came before it"
        if before is None or temperature_k != before[0]:
            self._same_since_s, self._lit_s = measured_s, 0.0
        return self._wrong_with(temperature_k) or self._jump(before) or self._frozen(self._lit_s)

    def is_fresh(self, now_s: float) -> bool:
        """Whether there is a reading at ``now_s`` [s] that is young enough for light."""
        return self._last is not None and -AHEAD_S <= now_s - self._last[1] <= self.limits.pause_after_s

    def judge(self, now_s: float, power_w: float | None) -> str | None:
        """The fault at ``now_s`` [s], or None; ``power_w`` [W] is what is wanted, None if nobody commands."""
        fresh = self.is_fresh(now_s)
        wanted = power_w is not None and power_w > 0.0
        self._lit_s += max(0.0, now_s - self._judged_s) if wanted else 0.0
        self._judged_s = now_s
        if fresh:
            self._paused_s = None
        elif not wanted and (power_w is None or self._last is None):
            pass  # no readings are needed now; the silence of a camera that was needed goes on
        elif self._paused_s is None:
            self._paused_s = now_s
        elif now_s - self._paused_s > self.limits.fault_after_s - self.limits.pause_after_s:
            why = f"; readings are stamped {self._ahead_s:.3f} s in the future" if self._ahead_s else ""
            return f"no temperature for {self.limits.fault_after_s:g} s{why}"
        return None

    def obstacle(self, now_s: float) -> str | None:
        """What forbids a reset at ``now_s`` [s], or None."""
        if self._last is None or not self.is_fresh(now_s):
            return "there is no fresh temperature"
        return self._wrong_with(self._last[0]) or self._frozen(self._last[1] - self._same_since_s)

    def _wrong_with(self, temperature_k: float) -> str | None:
        if not math.isfinite(temperature_k):
            return f"the temperature is {temperature_k}"
        if temperature_k > self.limits.max_temperature_k:
            excess_k = temperature_k - self.limits.max_temperature_k
            return f"the strip is {excess_k:.1f} K above its highest temperature"
        if temperature_k < self.limits.min_temperature_k:
            lack_k = self.limits.min_temperature_k - temperature_k
            return f"the temperature is {lack_k:.1f} K below what the camera can measure"
        return None

    def _jump(self, before: tuple[float, float] | None) -> str | None:
        assert self._last is not None
        if before is None or not 0.0 <= self._last[1] - before[1] <= self.limits.fault_after_s:
            return None
        jump_k = abs(self._last[0] - before[0])
        return (
            f"the temperature jumped by {jump_k:.1f} K between two readings"
            if jump_k > self.limits.max_jump_k
            else None
        )

    def _frozen(self, same_s: float) -> str | None:
        """The fault if the readings have been the same for as long [s] as no working camera's are."""
        limit_s = self.limits.frozen_after_s
        if limit_s == 0.0 or not same_s >= limit_s - 1e-9:
            return None
        return f"the temperature has not changed for {same_s:.1f} s, as if frozen"
