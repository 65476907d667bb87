# SPDX-License-Identifier: Apache-2.0
"""Position control by the identified model, which §6.5.3 and §8.2 of Wu (2021) propose for later work."""

import math
from typing import Final

from lce_control.filters import Sample
from lce_control.observer import Observer
from lce_control.time_optimal import fastest_power_w
from lce_data.channels import TEMPERATURE
from lce_model import Model, Stepper

STREAM_S: Final = 0.05
"""Targets that follow each other sooner are a trajectory, others are steps [s]."""


class ModelController:
    """The fastest approach that the model allows, decided anew with every sample::

        P = the most power that, held for horizon_s, does not carry the strip beyond the target

    in the dark afterwards (:func:`fastest_power_w`), from the state that the :class:`Observer` estimates. That is full
    power until the switching time that the model predicts, then what holds the target. The model knows minor loops and
    creep. The observer is the feedback: where the strip differs from the model, gain, drift and bias of the estimated
    strip change. Following the bias is an integral action without windup.

    A target that moves is met where it will be; its rate is that between targets that follow each other closely.

    Parameters
    ----------
    model : the identified model of the strip.
    max_power_w : limit of the power [W].
    hottest_k : the strip is not heated beyond this temperature [K].
    horizon_s : how long a power is planned to be held [s]; longer is calmer.
    camera_noise_k : standard deviation of the camera's noise [K].
    bias_s : time constant of the bias of the displacement [s].
    delay_s : time until the laser applies a new power [s]; until then it applies the present one.
    """

    def __init__(
        self,
        model: Model,
        max_power_w: float = 2.0,
        hottest_k: float = math.inf,
        horizon_s: float = 0.3,
        camera_noise_k: float = TEMPERATURE.noise,
        bias_s: float = 0.05,
        delay_s: float = 0.0,
    ) -> None:
        self.max_power_w, self.hottest_k, self.horizon_s = max_power_w, hottest_k, horizon_s
        self.delay_s = delay_s
        self._model, self._camera_noise_k, self._bias_s = model, camera_noise_k, bias_s
        Stepper(model)  # compiles what steps it, which at the first image would hold up the loop for seconds
        self.reset()

    def reset(self) -> None:
        """Forget the past. The next image of the camera is taken for that of a strip at rest."""
        self.observer: Observer | None = None
        self._t_s = self._image_s = -math.inf
        self._target = Sample(math.nan, -math.inf)
        self._rate_m_s = 0.0
        self._power_w = 0.0

    def observe(
        self, t_s: float, displacement: Sample | None, temperature: Sample | None, applied_w: float | None = None
    ) -> None:
        """Take in what was measured until now. A time before the last one starts the controller anew.

        Parameters
        ----------
        t_s : now [s].
        displacement : newest displacement [m]; None if there is no new one.
        temperature : newest temperature [K], with the time of the image; None before the first.
        applied_w : power since the last call [W]; None: the power that was decided then.
        """
        if t_s < self._t_s:
            self.reset()
        if self.observer is None:
            if temperature is None:
                return
            self.observer = Observer(self._model, temperature.value, self._camera_noise_k, self._bias_s)
            self._t_s = t_s
        dt_s, self._t_s = t_s - self._t_s, t_s
        self.observer.advance(self._power_w if applied_w is None else applied_w, t_s, dt_s)
        if temperature is not None and temperature.t_s > self._image_s:
            self._image_s = temperature.t_s
            self.observer.see_temperature(temperature)
        if displacement is not None:
            self.observer.see_displacement(displacement.value, dt_s)

    def power_w(self, target_m: float, present_w: float = 0.0) -> float:
        """Power [W] towards a target [m], while ``present_w`` [W] is applied; zero before the first image."""
        if self.observer is None:
            return 0.0
        self._follow(target_m)
        strip = self.observer.strip.copy()
        strip.step(present_w, self.delay_s)
        then_m = target_m + self._rate_m_s * (self._t_s - self._target.t_s + self.delay_s)
        self._power_w = fastest_power_w(strip, then_m, self.horizon_s, self.max_power_w, self.hottest_k, self._rate_m_s)
        return self._power_w

    def step(self, t_s: float, target_m: float, displacement: Sample, temperature: Sample) -> float:
        """Power [W] at ``t_s`` [s]: observe, then decide."""
        self.observe(t_s, displacement, temperature)
        return self.power_w(target_m)

    def _follow(self, target_m: float) -> None:
        since_s = self._t_s - self._target.t_s
        if target_m != self._target.value:
            streams = 0.0 < since_s < STREAM_S
            self._rate_m_s = (target_m - self._target.value) / since_s if streams else 0.0
            self._target = Sample(target_m, self._t_s)
        elif since_s >= STREAM_S:
            self._rate_m_s = 0.0
