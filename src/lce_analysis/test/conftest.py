# SPDX-License-Identifier: Apache-2.0
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

Floats = NDArray[np.float64]

CAMERA_K, DISTANCE_M = 0.06, 4e-6


@pytest.fixture(scope="session")
def strip() -> Model:
    return default_model("lumped", "equilibrium")


@pytest.fixture(scope="session")
def recorded(strip: Model) -> Callable[..., Run]:
    """A run of the strip as the bench would record it: camera at 10 Hz, distance at 100 Hz, white noise.

    ``extra`` (time [s], temperature [K], displacement [m]) → [m] is added to the displacement before the noise.
    """

    def record(
        name: str = "pulse",
        seed: int = 0,
        duration_s: float = 80.0,
        power: Callable[[Floats], Floats] = lambda t: np.where((t > 1.0) & (t < 25.0), 1.3, 0.0),
        extra: Callable[[Floats, Floats, Floats], Any] = lambda t, k, d: 0.0,
        temperature: bool = True,
        displacement: bool = True,
    ) -> Run:
        rng = np.random.default_rng(seed)
        time = np.arange(0.0, duration_s, 0.01)
        power_w = power(time)
        made = simulate(strip, time, power_w)
        seen_t = made.temperature_k[::10] + CAMERA_K * rng.standard_normal(time[::10].size)
        seen_d = made.displacement_m + extra(time, made.temperature_k, made.displacement_m)
        seen_d = seen_d + DISTANCE_M * rng.standard_normal(time.size)
        return Run.of(
            name,
            power=Series(time, power_w),
            temperature=Series(time[::10], seen_t) if temperature else None,
            displacement=Series(time, seen_d) if displacement else None,
            sha256="0" * 64,
        )

    return record
