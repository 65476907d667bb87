# SPDX-License-Identifier: Apache-2.0
"""What the camera and the distance sensor make of a response, and the CSV file of an experiment."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .simulation import Response

ZERO_CELSIUS_K = 273.15
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Noise:
    """Noise of one sensor, in its unit: white, plus slow AR(1) noise (`slow_memory` a sample), rounded."""

    white_rms: float
    slow_rms: float = 0.0
    slow_memory: float = 0.95
    quantum: float = 0.0

    def __post_init__(self) -> None:
        for name in ("white_rms", "slow_rms", "slow_memory", "quantum"):
            upper = 1.0 if name == "slow_memory" else np.inf
            if not 0.0 <= getattr(self, name) < upper:
                raise ValueError(f"{name} = {getattr(self, name)!r}, must be in [0, {upper:g})")

    def spoil(self, value: Floats, random: np.random.Generator) -> Floats:
        """The measured series (n,) of a true one (n,)."""
        measured = value + self.white_rms * random.standard_normal(value.size)
        if self.slow_rms > 0.0:
            kicks = self.slow_rms * np.sqrt(1.0 - self.slow_memory**2) * random.standard_normal(value.size)
            slow = self.slow_rms * random.standard_normal()
            for n, kick in enumerate(kicks):
                measured[n] += slow
                slow = self.slow_memory * slow + kick
        return np.round(measured / self.quantum) * self.quantum if self.quantum > 0.0 else measured


CAMERA = Noise(white_rms=0.06)  # K
DISTANCE = Noise(white_rms=4e-6)  # m


@dataclass(frozen=True)
class Samples:
    """What was measured: power, displacement at `time_s` (n,), temperature at `time_s[camera_index]` (m,)."""

    time_s: Floats
    power_w: Floats
    displacement_m: Floats
    camera_index: NDArray[np.int64]
    temperature_k: Floats


def measure(
    response: Response,
    seed: int,
    *,
    camera: Noise = CAMERA,
    distance: Noise = DISTANCE,
    camera_period_s: float = 0.1,
) -> Samples:
    """Sample a response: the distance at each of its times, the surface temperature each `camera_period_s`.

    The two sensors draw from streams of their own: changing one's noise leaves the other's as it was.
    """
    camera_random, distance_random = (np.random.default_rng([seed, stream]) for stream in (0, 1))
    frames = np.floor((response.time_s - response.time_s[0]) / camera_period_s + 1e-9).astype(np.int64)
    index = np.flatnonzero(np.diff(frames, prepend=-1))
    return Samples(
        time_s=response.time_s,
        power_w=response.power_w,
        displacement_m=distance.spoil(response.displacement_m, distance_random),
        camera_index=index,
        temperature_k=camera.spoil(response.surface_temperature_k[index], camera_random),
    )


def write_csv(path: Path | str, samples: Samples) -> Path:
    """Write an experiment's CSV, `time_s,power_w,temperature_c,displacement_m`; empty where not sampled."""
    celsius = samples.temperature_k - ZERO_CELSIUS_K
    seen = {n: f"{value:.6f}" for n, value in zip(samples.camera_index.tolist(), celsius, strict=True)}
    with Path(path).open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["time_s", "power_w", "temperature_c", "displacement_m"])
        for n, (time, power, displacement) in enumerate(
            zip(samples.time_s, samples.power_w, samples.displacement_m, strict=True)
        ):
            table.writerow([f"{time:.6f}", f"{power:.9g}", seen.get(n, ""), f"{displacement:.9f}"])
    return Path(path)
