# SPDX-License-Identifier: Apache-2.0
"""What a model knows of the strip: its state, branch and history included, corrected by what is measured."""

import math
from collections import deque
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from lce_control.filters import Sample
from lce_model import Model, Stepper

FIRST: Final = (0.1, 0.15, 0.05)
"""Standard deviations at the start: of the temperature [K], of the gain [1], of the drift [K/s]."""
WALK: Final = (1e-3, 0.02, 0.02)
"""The same, by how much they may have changed after a second."""
REMEMBERED: Final = 64
"""Steps that a camera's image may be old."""


class BelievedStrip(Stepper):
    """The strip of a model under disturbances that are constant for now.

    Attributes
    ----------
    gain : share of the laser power that heats as the model says [1]: a weak laser, dirt, an absorption that is off.
    drift_k_s : rate that is added to that of the temperature [K/s]: colder surroundings, a draught.
    bias_m : added to the displacement [m]: a load, a deformation model that is off.
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
    """Estimates the strip from the power that was applied and the samples that came, the camera's with their age.

    Temperature, gain and drift by an extended Kalman filter: it advances with the model, whose derivatives are taken
    numerically, and is corrected by each image, compared with the temperature of the time when it was taken. The order
    of the strip follows the estimated temperature, so its branch is the one that the strip has really come on. What is
    then left of the displacement is the bias, filtered with the time constant ``bias_s`` [s].

    ``strip`` starts at rest at the temperature that is given [K].
    """

    def __init__(self, model: Model, temperature_k: float, camera_noise_k: float = 0.06, bias_s: float = 0.05) -> None:
        self.strip = BelievedStrip(model, temperature_k)
        self.strip.step(0.0, 0.0)
        self.camera_noise_k, self.bias_s = camera_noise_k, bias_s
        self._covariance: NDArray[np.float64] = np.diag(np.square(FIRST))
        self._past: deque[Sample] = deque(maxlen=REMEMBERED)

    def advance(self, power_w: float, t_s: float, dt_s: float) -> None:
        """Go on to ``t_s`` [s] under ``power_w`` [W], which was applied for the ``dt_s`` [s] before."""
        dark, warmer = self.strip.twin(), self.strip.twin(1.0)
        self.strip.step(power_w, dt_s)
        dark.step(0.0, dt_s)
        warmer.step(power_w, dt_s)
        by_gain = (self.strip.temperature_k - dark.temperature_k) / max(self.strip.gain, 0.1)
        by_temperature = warmer.temperature_k - self.strip.temperature_k
        forward = np.array([[by_temperature, by_gain, dt_s], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        self._covariance = forward @ self._covariance @ forward.T + dt_s * np.diag(np.square(WALK))
        self._past.append(Sample(self.strip.measured_temperature_k, t_s))

    def see_temperature(self, sample: Sample) -> None:
        """Take in an image of the camera [K]; each only once."""
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
