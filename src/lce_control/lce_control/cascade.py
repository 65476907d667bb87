# SPDX-License-Identifier: Apache-2.0
"""Control loops: a filter with a PID, and two of them as the cascade of Fig. 6.2 of Wu (2021)."""

import math
from typing import Final

from lce_control.filters import LowPass, Sample
from lce_control.pid import PID, Gains, Limits

FOLLOW_K: Final = 2.0
"""Default distance of the outer loop [K]: well above the camera's noise, well below the way to a target."""


class Loop:
    """One closed loop: (6.1) in the feedback, (6.2) or (6.9) as the controller.

    From displacement [m] to power [W] it is the single loop of §6.5.3. In the cascade, the inner loop goes from
    temperature [K] to power [W] and the outer loop from displacement [m] to a temperature setpoint [K].
    """

    def __init__(self, pid: PID, feedback: LowPass) -> None:
        self.pid, self.feedback = pid, feedback

    @classmethod
    def of(cls, gains: Gains, limits: Limits, filter_s: float = 0.1) -> "Loop":
        """A loop with these gains, limits of the output, and time constant T_f [s] of the feedback filter."""
        return cls(PID(gains, limits), LowPass(filter_s))

    def step(
        self, t_s: float, setpoint: float, measured: Sample, feedforward: float = 0.0, integrate: bool = True
    ) -> float:
        """Output at ``t_s`` [s]; see :meth:`PID.step`."""
        return self.pid.step(t_s, setpoint, self.feedback.step(measured), feedforward, integrate)

    def reset(self, output: float | None = None) -> None:
        """Forget the past; see :meth:`PID.reset`."""
        self.feedback.reset()
        self.pid.reset(output)


class OuterLoop:
    """The outer loop of Fig. 6.2: displacement [m] to temperature setpoint [K]::

        T_d = inverse(d_d) + C_out (d_d - d),  within the limits of the PID

    ``inverse`` is the feed-forward of §6.4, from the chart of the model; here its result is an argument. The integral
    of C_out corrects the errors of the chart, which only show once the strip is as hot as its setpoint. It rests while
    the strip is further than ``follow_k`` [K] from the setpoint: the power is at its limit, or the strip is on its way.
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

    Attributes
    ----------
    setpoint_k : temperature setpoint of the last step [K]; NaN before the first.
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
