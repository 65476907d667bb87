# SPDX-License-Identifier: Apache-2.0
"""Sensor noise of a truth: a white part, a correlated part, quantisation."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Noise:
    """Noise of one sensor.

    rms : of the noise [unit of the sensor]; each run has its own, within 30 %.
    memory : of the correlated part, from sample to sample.
    slow : share of the variance that is correlated: 0 is white noise, 1 is autoregressive noise of first order.
    quantum : of the reading.
    """

    rms: float
    memory: float
    slow: float
    quantum: float

    def spoil(self, ideal: Floats, rng: np.random.Generator) -> Floats:
        """The reading (n,) of an ideal one (n,)."""
        rms = self.rms * rng.uniform(0.7, 1.3)
        kicks = rng.standard_normal(ideal.size) * math.sqrt(1.0 - self.memory**2)
        kicks[0] = rng.standard_normal()
        correlated = lfilter([1.0], [1.0, -self.memory], kicks)
        white = rng.standard_normal(ideal.size)
        noisy = ideal + rms * (math.sqrt(1.0 - self.slow) * white + math.sqrt(self.slow) * correlated)
        return np.asarray(np.round(noisy / self.quantum) * self.quantum)


MIXED = Noise(0.06, 0.6, 0.2, 0.01), Noise(4e-6, 0.9, 0.2, 1e-7)
"""Camera [K] and distance [m]: a fifth of the variance is slow."""
AUTOREGRESSIVE = Noise(0.06, 0.6, 1.0, 0.01), Noise(4e-6, 0.8, 1.0, 1e-7)
