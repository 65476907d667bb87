# SPDX-License-Identifier: Apache-2.0
"""The simulated sensor: rate, noise, digits and delay."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from lce_drivers.sensor import Reading


@dataclass(frozen=True, slots=True)
class Imperfection:
    """What a sensor does to the truth; zero for nothing.

    Parameters
    ----------
    noise_rms, quantum : standard deviation of the noise and step of the digits [SI unit of the channel].
    latency_s : from the acquisition to the reading [s].
    """

    noise_rms: float
    quantum: float
    latency_s: float

    def __post_init__(self) -> None:
        for name in self.__slots__:
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name}: {value:g} is not within [0, inf)")

    @property
    def variance(self) -> float:
        """Variance of a reading: noise and rounding."""
        return self.noise_rms**2 + self.quantum**2 / 12.0


class SimulatedSensor:
    """Samples the simulated strip ``rate_hz`` times a second [Hz], adds Gaussian noise, rounds to the quantum.

    A reading is handed over with the first sample of the strip that is at least the latency younger. The noise of the
    n-th reading depends on ``seed`` (-1: from the operating system), ``stream`` and n alone; the stream, a name, gives
    two sensors with the same seed different noise.
    """

    def __init__(self, imperfection: Imperfection, seed: int, stream: str, rate_hz: float = math.inf) -> None:
        self.imperfection = imperfection
        self._rate_hz = rate_hz
        self._period = -1
        self._on_the_way: deque[Reading] = deque()
        self._random = np.random.default_rng(None if seed < 0 else [seed, *stream.encode()])

    def observe(self, truth: float, t_s: float) -> list[Reading]:
        """Take in the true value at ``t_s`` [s]; the readings that are ready by then, oldest first."""
        if math.isfinite(truth) and self._is_due(t_s):
            self._on_the_way.append(Reading(self._measure(truth), t_s, self.imperfection.variance))
        ready = []
        while self._on_the_way and self._on_the_way[0].t_s + self.imperfection.latency_s <= t_s + 1e-9:
            ready.append(self._on_the_way.popleft())
        return ready

    def _is_due(self, t_s: float) -> bool:
        if math.isinf(self._rate_hz):
            return True
        # A millionth of a period more, or rounding could put a sample at a multiple of the period before it.
        period = math.floor(t_s * self._rate_hz + 1e-6)
        due = period != self._period
        self._period = period
        return due

    def _measure(self, truth: float) -> float:
        value = truth + self.imperfection.noise_rms * float(self._random.standard_normal())
        quantum = self.imperfection.quantum
        return round(value / quantum) * quantum if quantum > 0.0 else value
