# SPDX-License-Identifier: Apache-2.0
"""The Hammerstein–Wiener model found from runs of a strip that is not linear in the power."""

import numpy as np
import pytest

from lce_analysis.identification import fit
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

NOISE_K = 0.06
STRIP = default_model("lumped", "none", ("laser_saturation",)).set(
    {"lumped.gain": 60.0, "laser_saturation.curvature": 0.3}
)
"""A curve before a linear block, which no break points match exactly."""


def recorded(name: str, power_w: np.ndarray, seed: int) -> Run:
    """A camera of 10 Hz looks at the strip."""
    time = np.arange(power_w.size) * 0.01
    temperature = simulate(STRIP, time, power_w).temperature_k[::10]
    noisy = temperature + NOISE_K * np.random.default_rng(seed).standard_normal(temperature.size)
    return Run.of(name, Series(time, power_w), Series(time[::10], noisy), sha256=name)


def zigzag(corners_w: list[float]) -> np.ndarray:
    """Straight from corner to corner, 6 s each: every power is visited."""
    return np.interp(np.arange(600 * (len(corners_w) - 1)), 600 * np.arange(len(corners_w)), corners_w)


def error_k(model: Model, run: Run) -> float:
    """RMS error against the measured temperature."""
    assert run.power is not None and run.temperature is not None
    found = simulate(model, run.power.time_s, run.power.value).temperature_k[::10]
    return float(np.sqrt(np.mean((found - run.temperature.value) ** 2)))


@pytest.mark.slow
def test_it_describes_a_strip_that_no_lumped_model_does() -> None:
    runs = [
        recorded("up", zigzag([0.0, 2.0, 1.0, 2.0, 0.5, 1.5, 0.0, 0.0]), 1),
        recorded("mixed", zigzag([1.0, 0.0, 1.8, 1.8, 0.2, 0.8, 0.0]), 2),
    ]
    unseen = recorded("unseen", zigzag([0.5, 1.7, 0.3, 1.9, 0.7, 1.1, 0.0]), 3)
    found = {name: fit(default_model(name, "none"), runs).model for name in ("lumped", "hammerstein_wiener")}
    assert error_k(found["lumped"], unseen) > 15.0 * NOISE_K
    assert error_k(found["hammerstein_wiener"], unseen) < 2.0 * NOISE_K
    assert found["hammerstein_wiener"]["ambient.t_env"] == pytest.approx(301.15, abs=0.2)
    assert found["hammerstein_wiener"]["hammerstein_wiener.p_max"] == 2.0
