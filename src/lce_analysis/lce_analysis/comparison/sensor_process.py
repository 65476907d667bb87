# SPDX-License-Identifier: Apache-2.0
"""The noise of a sensor as a process that can be drawn from: how large, and how correlated from sample to sample."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from lce_analysis.diagnosis.whitening import autoregressive
from lce_data.noise import noise_floor
from lce_data.run import Series

Floats = NDArray[np.float64]

WINDOWS: Final = (128, 64, 32)
"""Samples in which a cubic stands for what the model lacks; the longest of which a series has :data:`ENOUGH`."""
ENOUGH: Final = 8
CALM: Final = 0.5
"""Share of the windows that counts, those with the least energy: corners of the misfit stay out of it."""
SETTLING: Final = 500
"""Samples after which a process has forgotten where it began."""


@dataclass(frozen=True)
class SensorProcess:
    """Autoregressive noise: coefficients (p,), and the standard deviation of the noise in the unit of the series."""

    coefficients: Floats
    rms: float

    def draw(self, random: np.random.Generator, rows: int, size: int) -> Floats:
        """Rows (rows, size) of noise."""
        if not self.coefficients.size:
            return self.rms * random.standard_normal((rows, size))
        white = random.standard_normal((rows, size + SETTLING))
        noise = lfilter(np.ones(1), self._whitening, white)[:, SETTLING:]
        return np.asarray(noise * self._innovation)

    @property
    def of_means(self) -> float:
        """Standard deviation that white noise would need to move the mean of many samples as much."""
        return self._innovation / abs(1.0 - float(np.sum(self.coefficients)))

    @property
    def _whitening(self) -> Floats:
        return np.concatenate([[1.0], -self.coefficients])

    @property
    def _innovation(self) -> float:
        """Standard deviation of what is new in each sample."""
        response = lfilter(np.ones(1), self._whitening, np.eye(1, 20 * SETTLING)[0])
        return self.rms / float(np.linalg.norm(response))


def sensor_process(series: Sequence[Series], residuals: Sequence[Floats]) -> SensorProcess:
    """The noise of a sensor from what it measured in several runs, and what a model leaves of that (n,).

    Its size is that of :func:`lce_data.noise.noise_floor` of the residuals, at most that of the series: what the model
    lacks is smoother than noise, and does not count. Its correlation is that of the residuals around a cubic in windows
    of a hundred samples, the calmer half of them, for the same reason.
    """
    floors = [min(noise_floor(s), noise_floor(Series(s.time_s, r))) for s, r in zip(series, residuals, strict=True)]
    rest = [part for r in residuals for part in _calm(r)]
    coefficients = autoregressive(rest).coefficients if rest else np.empty(0)
    return SensorProcess(coefficients, float(np.sqrt(np.mean(np.square(floors)))))


def _calm(residual: Floats) -> Floats:
    """Windows (m, n) of a residual around a cubic; none where it is too short."""
    window = next((w for w in WINDOWS if residual.size >= ENOUGH * w), None)
    if window is None:
        return np.empty((0, 0))
    parts = residual[: residual.size // window * window].reshape(-1, window)
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, window), 4))
    rest = parts - parts @ basis @ basis.T
    energy = np.sum(rest**2, axis=1)
    return np.asarray(rest[energy <= np.quantile(energy, CALM)])
