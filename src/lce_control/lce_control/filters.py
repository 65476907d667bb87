# SPDX-License-Identifier: Apache-2.0
"""Filters of sampled signals, exact for signals that are straight between samples, however far apart these are."""

import math
from typing import NamedTuple


class Sample(NamedTuple):
    """A value and the time [s] at which it was measured; a controller may see the same one many times."""

    value: float
    t_s: float


class LowPass:
    """First-order low-pass filter, (6.1)::

        F(s) = K_f / (T_f s + 1)

    With a = exp(-dt/T_f) and an input that is straight from u0 to u1 over dt::

        y = a y0 + K_f (u1 - a u0 - (u1 - u0) (1 - a) T_f/dt)

    T_f = 0 passes K_f u through. The first sample starts the filter in its steady state, and so does one that is
    older than the last (a clock that was set back). The same sample again changes nothing.

    Attributes
    ----------
    time_constant_s : T_f [s]; may be set at any time.
    gain : K_f [1]; may be set at any time.
    """

    def __init__(self, time_constant_s: float = 0.1, gain: float = 1.0) -> None:
        self.time_constant_s, self.gain = time_constant_s, gain
        self._input: Sample | None = None
        self._output = 0.0

    def step(self, sample: Sample) -> Sample:
        """Take in a sample; return the filtered value at the same time."""
        last, self._input = self._input, sample
        if last is None or sample.t_s < last.t_s:
            self._output = self.gain * sample.value
        elif sample.t_s > last.t_s:
            self._output = self._advanced(last.value, sample.value, sample.t_s - last.t_s)
        return Sample(self._output, sample.t_s)

    def reset(self) -> None:
        """Forget everything: the next sample is the first."""
        self._input = None

    def _advanced(self, before: float, now: float, dt_s: float) -> float:
        if self.time_constant_s == 0.0:
            return self.gain * now
        faded = -math.expm1(-dt_s / self.time_constant_s)
        lag = (now - before) * faded * self.time_constant_s / dt_s
        return (1.0 - faded) * self._output + self.gain * (now - (1.0 - faded) * before - lag)


class Slope:
    """Filtered derivative, the last term of (6.2) and (6.9)::

        N / (1 + N/s)  =  N s / (s + N)

    the derivative after a low-pass filter of the time constant 1/N. With a = exp(-N dt), for an input that is straight
    over dt::

        y = a y0 + (1 - a) (u1 - u0)/dt

    dt is the time between two *measurements*. A value that is held from one to the next so has the slope of the signal,
    not a kick at each new sample and zero in between. The slope is zero at the first sample, and at one that is older
    than the last.

    Attributes
    ----------
    coefficient : N [1/s]; a new one leaves the slope as it is.
    value : the present slope [unit of the signal per second].
    """

    def __init__(self, coefficient: float = 100.0) -> None:
        self.coefficient = coefficient
        self.value = 0.0
        self._input: Sample | None = None

    def step(self, sample: Sample) -> float:
        """Take in a sample; return the slope [unit of the signal per second] at its time."""
        last, self._input = self._input, sample
        if last is None or sample.t_s < last.t_s:
            self.value = 0.0
        elif sample.t_s > last.t_s:
            dt_s = sample.t_s - last.t_s
            self.value -= math.expm1(-self.coefficient * dt_s) * ((sample.value - last.value) / dt_s - self.value)
        return self.value

    def reset(self) -> None:
        """Forget everything: the next sample is the first."""
        self._input, self.value = None, 0.0
