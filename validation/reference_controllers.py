# SPDX-License-Identifier: Apache-2.0
"""Reference controllers: a mode of control as one plain object, which does what its nodes do together, without ROS."""

from collections.abc import Callable

from lce_control.cascade import Cascade, Loop, OuterLoop
from lce_control.filters import Sample
from lce_model import Model
from lce_model.inverse import temperature_from_here_k

ReferenceController = Callable[[float, float, Sample, Sample], float]
"""(t_s, target [m], displacement [m], temperature [K]) → power [W]; `ModelController.step` is one too."""


class DoubleLoop:
    """Fig. 6.2 of Wu (2021) as `feedforward` (branch: actual), `outer_controller` and `inner_controller` do it.

    Parameters
    ----------
    model : gives the feed-forward of each new target, from the present state of the strip.
    outer, inner : the loops of the cascade.
    deadband_k : reversals of the measured temperature smaller than this are noise [K].
    """

    def __init__(self, model: Model, outer: OuterLoop, inner: Loop, deadband_k: float = 0.3) -> None:
        self.cascade = Cascade(outer, inner)
        self._model, self._deadband_k = model, deadband_k
        self._past: list[Sample] = []
        self._target_m: float | None = None
        self._feedforward_k = 0.0

    def step(self, t_s: float, target_m: float, displacement: Sample, temperature: Sample) -> float:
        """Power [W] at ``t_s`` [s]; raises OutOfReach for a target that the model does not reach."""
        if not self._past or temperature.t_s > self._past[-1].t_s:
            self._past.append(temperature)
        if target_m != self._target_m:
            self._target_m = target_m
            values, times = zip(*self._past, strict=True)
            self._feedforward_k = temperature_from_here_k(self._model, times, values, target_m, self._deadband_k)
        return self.cascade.step(t_s, target_m, self._feedforward_k, displacement, temperature)


class SingleLoop:
    """The single loop of §6.5.3, as `single_controller` does it; it ignores the temperature."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop

    def step(self, t_s: float, target_m: float, displacement: Sample, temperature: Sample) -> float:
        """Power [W] at ``t_s`` [s]."""
        return self.loop.step(t_s, target_m, displacement)
