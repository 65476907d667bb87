# SPDX-License-Identifier: Apache-2.0
"""The modes of control as plain objects that follow a target: what their nodes do together, without ROS."""

from collections.abc import Callable

from lce_control.filters import Sample
from lce_control.loops import Cascade, Loop, OuterLoop
from lce_model import Model
from lce_model.inverse import temperature_from_here_k

Follower = Callable[[float, float, Sample, Sample], float]
"""(t_s, target [m], displacement [m], temperature [K]) → power [W]; ModelController.step is one too."""


class DoubleLoop:
    """Fig. 6.2 with its feed-forward: for each new target, the temperature from where the strip is.

    As `feedforward` (branch: actual), `outer_controller` and `inner_controller` do it; reversals of the measured
    temperature smaller than ``deadband_k`` [K] are noise. OutOfReach for a target that ``model`` does not reach.
    """

    def __init__(self, model: Model, outer: OuterLoop, inner: Loop, deadband_k: float = 0.3) -> None:
        self.cascade = Cascade(outer, inner)
        self._model, self._deadband_k = model, deadband_k
        self._past: list[Sample] = []
        self._target_m: float | None = None
        self._feedforward_k = 0.0

    def step(self, t_s: float, target_m: float, displacement: Sample, temperature: Sample) -> float:
        """Power [W] at ``t_s`` [s]."""
        if not self._past or temperature.t_s > self._past[-1].t_s:
            self._past.append(temperature)
        if target_m != self._target_m:
            self._target_m = target_m
            values, times = zip(*self._past, strict=True)
            self._feedforward_k = temperature_from_here_k(self._model, times, values, target_m, self._deadband_k)
        return self.cascade.step(t_s, target_m, self._feedforward_k, displacement, temperature)


class SingleLoop:
    """The single loop of §6.5.3, as `single_controller` does it: the temperature is not looked at."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop

    def step(self, t_s: float, target_m: float, displacement: Sample, temperature: Sample) -> float:
        """Power [W] at ``t_s`` [s]."""
        return self.loop.step(t_s, target_m, displacement)
