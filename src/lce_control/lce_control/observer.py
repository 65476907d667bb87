# SPDX-License-Identifier: Apache-2.0
"""The state of the strip as estimated by a model, its branch and history included, and corrected by measurements."""

import math
from collections import deque
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from lce_control.filters import Sample
from lce_data.channels import TEMPERATURE
from lce_model import Model, Stepper

START_SIGMA: Final = (0.1, 0.15, 0.05)
"""Standard deviations at the start: of the temperature [K], of the gain [1], of the drift [K/s]."""
WALK_SIGMA: Final = (1e-3, 0.02, 0.02)
"""Standard deviations of their random walk within a second: [K], [1], [K/s]."""
REMEMBERED: Final = 64
"""Steps for which temperatures are kept; an image of the camera may be so old."""


class EstimatedStrip(Stepper):
    """The strip of a model under disturbances that are constant for now.

    Attributes
    ----------
    gain : heating by the laser over that of the model [1]; a weak laser, dirt or a wrong absorption change it.
    drift_k_s : added to the rate of the temperature [K/s]; colder surroundings or a draught change it.
    bias_m : added to the displacement [m]; a load or a wrong deformation model change it.
    """

    gain, drift_k_s, bias_m = 1.0, 0.0, 0.0

    def step(self, power_w: float, dt_s: float) -> None:
        """Advance by ``dt_s`` [s] under constant power [W]."""
        super().step(max(self.gain, 0.0) * power_w, dt_s)
        self.correct(self.temperature_k + self.drift_k_s * dt_s)

    @property
    def displacement_m(self) -> float:
        """Displacement now [m]."""
        return super().displacement_m + self.bias_m

    def twin(self, warmer_k: float = 0.0) -> Self:
        """A copy, warmer by so much [K]."""
        copy = self.copy()
        copy.correct(copy.temperature_k + warmer_k)
        return copy


class Observer:
    """Estimates the strip from the applied power and from the samples of both sensors.

    An extended Kalman filter estimates temperature, gain and drift. It advances with the model, whose derivatives it
    takes numerically. Each image of the camera corrects it, compared with the temperature of the time when the image
    was taken. The order of the strip follows the estimated temperature, so its branch is the one that the real strip is
    on. The difference that is then left in the displacement is the bias, filtered with the time constant ``bias_s``.

    Parameters
    ----------
    model : the identified model of the strip.
    temperature_k : the strip starts at rest at this temperature [K].
    camera_noise_k : standard deviation of the camera's noise [K].
    bias_s : time constant of the bias [s].

    Attributes
    ----------
    strip : the estimated strip.
    """

    def __init__(
        self, model: Model, temperature_k: float, camera_noise_k: float = TEMPERATURE.noise, bias_s: float = 0.05
    ) -> None:
        self.strip = EstimatedStrip(model, temperature_k)
        self.strip.step(0.0, 0.0)
        self.camera_noise_k, self.bias_s = camera_noise_k, bias_s
        self._covariance: NDArray[np.float64] = np.diag(np.square(START_SIGMA))
        self._past: deque[Sample] = deque(maxlen=REMEMBERED)

    def advance(self, power_w: float, t_s: float, dt_s: float) -> None:
        """Advance to ``t_s`` [s] under ``power_w`` [W], which was applied for the last ``dt_s`` [s]."""
        dark, warmer = self.strip.twin(), self.strip.twin(1.0)
        self.strip.step(power_w, dt_s)
        dark.step(0.0, dt_s)
        warmer.step(power_w, dt_s)
        by_gain = (self.strip.temperature_k - dark.temperature_k) / max(self.strip.gain, 0.1)
        by_temperature = warmer.temperature_k - self.strip.temperature_k
        forward = np.array([[by_temperature, by_gain, dt_s], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        self._covariance = forward @ self._covariance @ forward.T + dt_s * np.diag(np.square(WALK_SIGMA))
        self._past.append(Sample(self.strip.measured_temperature_k, t_s))

    def see_temperature(self, sample: Sample) -> None:
        """Take in an image of the camera [K]; pass each image only once."""
        if not self._past:
            return
        then = min(self._past, key=lambda past: abs(past.t_s - sample.t_s))
        gain = self._covariance[:, 0] / (self._covariance[0, 0] + self.camera_noise_k**2)
        self._covariance -= np.outer(gain, self._covariance[0])
        warmer_k, more, drift_k_s = (gain * (sample.value - then.value)).tolist()
        self.strip.correct(self.strip.temperature_k + warmer_k)
        self.strip.gain += more
        self.strip.drift_k_s += drift_k_s
        self._past = deque((Sample(t.value + warmer_k, t.t_s) for t in self._past), REMEMBERED)

    def see_displacement(self, displacement_m: float, dt_s: float) -> None:
        """Take in a displacement [m], ``dt_s`` [s] after the last."""
        share = -math.expm1(-dt_s / self.bias_s)
        self.strip.bias_m += share * (displacement_m - self.strip.measured_displacement_m - self.strip.bias_m)
