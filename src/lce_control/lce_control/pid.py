# SPDX-License-Identifier: Apache-2.0
"""PID controller with filtered derivative, (6.2) and (6.9), for samples of any age."""

import math
from dataclasses import dataclass, fields

from lce_control.filters import Sample, Slope


@dataclass(frozen=True, slots=True)
class Gains:
    """Gains of a PID, in [unit of the output / unit of the input] and seconds.

    ``kp``, ``ki`` [1/s], ``kd`` [s] and the filter coefficient ``n`` [1/s] are K_p, K_i, K_d and N of (6.2).
    ``setpoint_weight`` b and ``derivative_weight`` c say how much of the setpoint the proportional and the derivative
    term see; b = c = 1 is (6.2) as printed. With c = 0 a step of the setpoint does not kick the output.
    """

    kp: float
    ki: float = 0.0
    kd: float = 0.0
    n: float = 100.0
    setpoint_weight: float = 1.0
    derivative_weight: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{field.name}: {value:g} is not within [0, inf)")
        if self.n == 0.0:
            raise ValueError("n: 0 is not within (0, inf)")
        for name in ("setpoint_weight", "derivative_weight"):
            if getattr(self, name) > 1.0:
                raise ValueError(f"{name}: {getattr(self, name):g} is not within [0, 1]")


@dataclass(frozen=True, slots=True)
class Limits:
    """Lowest and highest output [unit of the output]."""

    lower: float
    upper: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.lower) and math.isfinite(self.upper) and self.lower <= self.upper):
            raise ValueError(f"limits: [{self.lower:g}, {self.upper:g}] is not a finite range")

    def clip(self, value: float) -> float:
        """The nearest value within."""
        return min(max(value, self.lower), self.upper)


class PID:
    """With the setpoint r, the sample y_k of the time t_k <= t, and a feed-forward f::

        v = slope of y, filtered: N / (1 + N/s), over the times between samples       (Slope)
        y = y_k + v min(t - t_k, horizon_s)        the measured value now, not when it was measured
        P = K_p (b r - y)
        D = K_d (c slope(r) - v)
        I = integral of K_i (r - y) dt             trapezoidal: exact for errors that run straight
        u = f + P + I + D, within the limits

    Time is an argument and may pass in any steps. A time before the last starts the controller anew.

    Anti-windup: an integral that would carry u beyond a limit stops at it, and one that finds u beyond a limit does not
    grow towards it; it may always come back. ``integrate=False`` holds it where it is: what comes after this controller
    does not follow it (the outer loop of a cascade while the inner one is still on its way).

    Bumpless: new gains at any time leave u where it is, the integral takes the difference; ``reset(u)`` lets the next
    step begin at u, and ``reset()`` with an empty integral. New limits hold from the next step on.

    Attributes
    ----------
    limits : of the output.
    horizon_s : how far a sample is carried along its slope [s]; 0 holds it.
    output, p, i, d : of the last step. ``limited`` is -1, 0, +1: at the lower limit, at none, at the upper one.
    """

    def __init__(self, gains: Gains, limits: Limits, horizon_s: float = 0.2) -> None:
        self.limits, self.horizon_s = limits, horizon_s
        self._gains = gains
        self._measured, self._setpoint = Slope(gains.n), Slope(gains.n)
        self._now: tuple[float, float] | None = None
        self._start: float | None = None
        self._t_s = 0.0
        self.output = self.p = self.i = self.d = 0.0
        self.limited = 0

    def step(
        self, t_s: float, setpoint: float, measured: Sample, feedforward: float = 0.0, integrate: bool = True
    ) -> float:
        """Output at ``t_s`` [s]."""
        if self._now is not None and t_s < self._t_s:
            self.reset()
        slope = self._measured.step(measured)
        self._setpoint.step(Sample(setpoint, t_s))
        value = measured.value + slope * min(max(t_s - measured.t_s, 0.0), self.horizon_s)
        before, self._now = self._now, (setpoint, value)
        self.p, self.d = self._instant(self._gains)
        rest = feedforward + self.p + self.d
        if before is None:
            self.i = 0.0 if self._start is None else self._start - rest
        elif integrate:
            mean_error = 0.5 * (before[0] - before[1] + setpoint - value)
            self.i += self._growth(self._gains.ki * mean_error * (t_s - self._t_s), rest + self.i)
        self._t_s = t_s
        wanted = rest + self.i
        self.output = self.limits.clip(wanted)
        self.limited = int(wanted >= self.limits.upper) - int(wanted <= self.limits.lower)
        return self.output

    def reset(self, output: float | None = None) -> None:
        """Forget the past; the next step gives ``output``, or begins with an empty integral."""
        self._measured.reset()
        self._setpoint.reset()
        self._now, self._start = None, output
        self.output = self.p = self.i = self.d = 0.0
        self.limited = 0

    @property
    def gains(self) -> Gains:
        """The gains; setting them does not move the output."""
        return self._gains

    @gains.setter
    def gains(self, gains: Gains) -> None:
        self._measured.coefficient = self._setpoint.coefficient = gains.n
        if self._now is not None:
            p, d = self._instant(gains)
            self.i += self.p + self.d - p - d
            self.p, self.d = p, d
        self._gains = gains

    def _instant(self, gains: Gains) -> tuple[float, float]:
        """Proportional and derivative term of the present moment."""
        assert self._now is not None
        setpoint, value = self._now
        p = gains.kp * (gains.setpoint_weight * setpoint - value)
        return p, gains.kd * (gains.derivative_weight * self._setpoint.value - self._measured.value)

    def _growth(self, growth: float, wanted: float) -> float:
        """What the integral may grow by where the output is ``wanted`` without it."""
        if growth > 0.0:
            return min(growth, max(0.0, self.limits.upper - wanted))
        return max(growth, min(0.0, self.limits.lower - wanted))
