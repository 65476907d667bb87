# SPDX-License-Identifier: Apache-2.0
"""PID controller with filtered derivative, (6.2) and (6.9), for samples of any age."""

import math
from dataclasses import dataclass, fields

from lce_control.filters import Sample, Slope


@dataclass(frozen=True, slots=True)
class Gains:
    """Gains of a PID, in U = unit of the output / unit of the input.

    Parameters
    ----------
    kp, ki, kd : K_p [U], K_i [U/s] and K_d [U s] of (6.2), 0 or more.
    n : filter coefficient N of the derivative [1/s], above 0.
    setpoint_weight : b, the share of the setpoint that the proportional term sees, from 0 to 1.
    derivative_weight : c, the share that the derivative sees. b = c = 1 is (6.2) as printed; with c = 0 a step of the
        setpoint does not kick the output.

    Raises
    ------
    ValueError
        If a value is out of its range; it names the field.
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
    """Lowest and highest output [unit of the output]; ValueError if they are not finite or in the wrong order."""

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
        I = integral of K_i (r - y) dt             trapezoidal: exact for errors that are straight
        u = f + P + I + D, within the limits

    Time is an argument and may pass in steps of any length. A time before the last one starts the controller anew.

    Anti-windup: an integral that would carry u beyond a limit stops there. If u is beyond a limit already, the integral
    does not grow towards it. It may always come back. ``integrate=False`` keeps the integral as it is, for times when
    the plant does not follow u: the outer loop of a cascade, while the inner loop is still on its way.

    Bumpless transfer: new gains leave u where it is, the integral takes the difference. After ``reset(u)`` the next
    step begins at u, after ``reset()`` with an empty integral. New limits hold from the next step on.

    Attributes
    ----------
    limits : of the output.
    horizon_s : how far a sample is carried along its slope [s]; 0 holds it.
    output, p, i, d : u and its terms in the last step.
    limited : -1 if the last output was at the lower limit, +1 at the upper one, else 0.

    Examples
    --------
    >>> inner = PID(Gains(kp=0.05, ki=0.01, kd=0.001), Limits(0.0, 2.0))  # (6.11): W from K
    >>> inner.step(0.0, setpoint=340.0, measured=Sample(320.0, 0.0))
    1.0
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
        """The output at a time.

        Parameters
        ----------
        t_s : now [s].
        setpoint : r [unit of the input].
        measured : the newest sample of y [unit of the input], with the time of its measurement.
        feedforward : f [unit of the output].
        integrate : whether the integral may change.

        Returns
        -------
        float
            u, within the limits.
        """
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
        """Forget the past. The next step gives ``output``; None: it begins with an empty integral."""
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
        """The part of ``growth`` that keeps an output of ``wanted`` within the limits."""
        if growth > 0.0:
            return min(growth, max(0.0, self.limits.upper - wanted))
        return max(growth, min(0.0, self.limits.lower - wanted))
