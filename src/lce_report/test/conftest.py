# SPDX-License-Identifier: Apache-2.0
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_data.channels import DISPLACEMENT, TEMPERATURE
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

Floats = NDArray[np.float64]


@pytest.fixture(scope="session")
def strip() -> Model:
    """The strip of which the runs are, known exactly."""
    return default_model("lumped", "equilibrium")


@pytest.fixture(scope="session")
def recorded(strip: Model) -> Callable[..., Run]:
    """Runs of the strip with the sensors' noise; ``extra(time, T, d)`` [m] is added to the displacement."""

    def record(
        name: str = "pulse",
        seed: int = 0,
        duration_s: float = 80.0,
        power: Callable[[Floats], Floats] = lambda t: np.where((t > 1.0) & (t < 25.0), 1.3, 0.0),
        extra: Callable[[Floats, Floats, Floats], Any] = lambda t, k, d: 0.0,
        temperature: bool = True,
    ) -> Run:
        rng, time = np.random.default_rng(seed), np.arange(0.0, duration_s, 0.01)
        made = simulate(strip, time, power(time))
        t = made.temperature_k[::10] + TEMPERATURE.noise * rng.standard_normal(time[::10].size)
        d = made.displacement_m + DISPLACEMENT.noise * rng.standard_normal(time.size)
        d = d + extra(time, made.temperature_k, made.displacement_m)
        camera = Series(time[::10], t) if temperature else None
        return Run.of(name, Series(time, power(time)), camera, Series(time, d), sha256="0" * 64)

    return record
