# SPDX-License-Identifier: Apache-2.0
"""The closed loop without nodes: timing of the sensors, limits, disturbances."""

import numpy as np
import pytest

from lce_control.filters import Sample
from lce_control.tuning.closed_loop import Sensors, run
from lce_data.errors import LceError
from lce_model import Stepper, default_model

STRIP = default_model("lumped", "kinetic")


def test_a_constant_power_gives_what_the_model_gives() -> None:
    loop = run(STRIP, lambda t, d, shot: 0.7, 5.0)
    strip = Stepper(STRIP)
    strip.step(0.0, 0.0)
    for temperature_k in loop.temperature_k:
        assert strip.temperature_k == temperature_k
        strip.step(0.7, 0.01)
    assert loop.energy_j == pytest.approx(3.5)


def test_the_camera_sees_ten_times_a_second_and_its_picture_comes_late() -> None:
    seen: list[tuple[float, Sample]] = []

    def control(t_s: float, displacement: Sample, temperature: Sample) -> float:
        assert displacement.t_s == t_s
        seen.append((t_s, temperature))
        return 1.0

    loop = run(STRIP, control, 1.0, Sensors(camera_noise_k=0.0, camera_latency_s=0.13))
    for t_s, shot in seen[13:]:
        taken = 10 * int((t_s - 0.13 + 1e-9) / 0.1)
        assert shot == (loop.temperature_k[taken], loop.time_s[taken])


def test_noise_is_that_of_the_seed() -> None:
    def noise(seed: int) -> tuple[float, float]:
        pairs: list[tuple[float, float]] = []

        def control(t_s: float, displacement: Sample, temperature: Sample) -> float:
            pairs.append((displacement.value, temperature.value))
            return 0.0

        loop = run(STRIP, control, 20.0, seed=seed)
        measured = np.array(pairs)
        assert np.std(measured[:, 0] - loop.displacement_m) == pytest.approx(4e-6, rel=0.1)
        assert np.std(measured[10::10, 1] - loop.temperature_k[10::10]) == pytest.approx(0.06, rel=0.2)
        return pairs[-1]

    assert noise(1) == noise(1) != noise(2)


def test_powers_are_limited() -> None:
    loop = run(STRIP, lambda t, d, shot: 50.0 if t < 1.0 else -1.0, 2.0, max_power_w=1.5)
    assert set(loop.power_w) == {0.0, 1.5}


def test_a_change_is_a_disturbance_of_the_running_strip() -> None:
    weaker = STRIP.set({"lumped.gain": 0.8 * STRIP["lumped.gain"]})
    loop = run(STRIP, lambda t, d, shot: 0.5, 400.0, changes=[(200.0, weaker)])
    assert loop.temperature_k[19999] - 301.15 == pytest.approx(0.5 * STRIP["lumped.gain"], rel=1e-3)
    assert loop.temperature_k[-1] - 301.15 == pytest.approx(0.4 * STRIP["lumped.gain"], rel=1e-3)
    with pytest.raises(LceError, match="other terms"):
        run(STRIP, lambda t, d, shot: 0.5, 1.0, changes=[(0.5, default_model("lumped", "dynamic"))])


def test_a_strip_that_lives_goes_on_from_where_it_is() -> None:
    strip = Stepper(STRIP)
    strip.step(0.0, 0.0)
    first = run(strip, lambda t, d, shot: 1.0, 3.0)
    second = run(strip, lambda t, d, shot: 1.0, 3.0)
    assert second.temperature_k[0] > first.temperature_k[-1]
    with pytest.raises(LceError, match="too short"):
        run(strip, lambda t, d, shot: 1.0, 0.0)
