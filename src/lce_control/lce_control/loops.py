# SPDX-License-Identifier: Apache-2.0
"""Control loops: a filter and a PID, and two of them as the cascade of Fig. 6.2."""

import math
from typing import Final

from lce_control.filters import LowPass, Sample
from lce_control.pid import PID, Gains, Limits

FOLLOW_K: Final = 2.0
"""Of the outer loop: well above the camera's noise, well below the way to a target [K]."""


class Loop:
    """One closed loop: (6.1) in the feedback, (6.2) or (6.9) as the controller.

    By itself, from displacement [m] to power [W], it is the single loop of §6.5.3; the inner loop of the cascade goes
    from temperature [K] to power [W], the outer one from displacement [m] to a temperature [K].
    """

    def __init__(self, pid: PID, feedback: LowPass) -> None:
        self.pid, self.feedback = pid, feedback

    @classmethod
    def of(cls, gains: Gains, limits: Limits, filter_s: float = 0.1) -> "Loop":
        """A loop of gains, limits of the output and T_f [s]."""
        return cls(PID(gains, limits), LowPass(filter_s))

    def step(
        self, t_s: float, setpoint: float, measured: Sample, feedforward: float = 0.0, integrate: bool = True
    ) -> float:
        """Output at ``t_s`` [s]; see PID.step."""
        return self.pid.step(t_s, setpoint, self.feedback.step(measured), feedforward, integrate)

    def reset(self, output: float | None = None) -> None:
        """Forget the past; see PID.reset."""
        self.feedback.reset()
        self.pid.reset(output)


class OuterLoop:
    """The outer loop of Fig. 6.2: displacement [m] to temperature setpoint [K]::

        T_d = inverse(d_d) + C_out (d_d - d),  within the limits of the PID

    ``inverse`` is the feed-forward of §6.4, from the chart of the model, and an argument here. The integral of C_out
    corrects what the chart gets wrong, which only shows once the strip is as hot as it was told: it rests while the
    strip is further than ``follow_k`` [K] from the setpoint (the power is at its limit, or the strip is on its way).
    """

    def __init__(self, loop: Loop, follow_k: float = FOLLOW_K) -> None:
        self.loop, self.follow_k = loop, follow_k

    def step(
        self, t_s: float, target_m: float, feedforward_k: float, displacement: Sample, temperature_k: float
    ) -> float:
        """Temperature setpoint [K] at ``t_s`` [s]; ``displacement`` [m] and ``temperature_k`` are measured."""
        follows = abs(self.loop.pid.output - temperature_k) <= self.follow_k
        return self.loop.step(t_s, target_m, displacement, feedforward_k, integrate=follows)

    def reset(self) -> None:
        """Forget the past."""
        self.loop.reset()


class Cascade:
    """Fig. 6.2 as a whole: outer PID beside the feed-forward, then the inner PID, from displacement to power.

    ``setpoint_k`` is the temperature that the last step asked for [K].
    """

    def __init__(self, outer: OuterLoop, inner: Loop) -> None:
        self.outer, self.inner = outer, inner
        self.setpoint_k = math.nan

    def step(
        self, t_s: float, target_m: float, feedforward_k: float, displacement: Sample, temperature: Sample
    ) -> float:
        """Power [W] at ``t_s`` [s] from measured displacement [m] and temperature [K]."""
        self.setpoint_k = self.outer.step(t_s, target_m, feedforward_k, displacement, temperature.value)
        return self.inner.step(t_s, self.setpoint_k, temperature)

    def reset(self) -> None:
        """Forget the past."""
        self.outer.reset()
        self.inner.reset()
        self.setpoint_k = math.nan
