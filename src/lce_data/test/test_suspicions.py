# SPDX-License-Identifier: Apache-2.0
"""What looks wrong about a run is said with its cure, and a good run is left in peace."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lce_data.run import Run, Series
from lce_data.suspicions import suspicions

Floats = NDArray[np.float64]


def run(
    seed: int = 0, gain: float = 60.0, tau_s: float = 15.0, step_s: float = 0.1, length_s: float = 120.0
) -> tuple[Floats, Floats, Floats, Floats]:
    """Time [s], power [W], temperature [K] and displacement [m] of a strip that is pulsed."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, length_s, step_s)
    power = np.where((time_s % (length_s / 2.0)) < length_s / 4.0, 1.0, 0.2)
    warm = np.empty(time_s.size)
    warm[0] = 0.0
    for i in range(1, time_s.size):
        warm[i] = warm[i - 1] + (1.0 - np.exp(-step_s / tau_s)) * (gain * power[i - 1] - warm[i - 1])
    temperature = 296.0 + warm + 0.06 * rng.standard_normal(time_s.size)
    return time_s, power, temperature, 1e-3 * np.tanh(warm / 40.0) + 4e-6 * rng.standard_normal(time_s.size)


def made(time_s: Floats, power: Floats, temperature: Floats, displacement: Floats | None = None) -> Run:
    moved = None if displacement is None else Series(time_s, displacement)
    return Run.of("r", Series(time_s, power), Series(time_s, temperature), moved)


@pytest.mark.parametrize("seed", range(5))
def test_a_good_run_raises_none(seed: int) -> None:
    assert suspicions(made(*run(seed))) == ()
    assert suspicions(made(*run(seed, gain=0.5, tau_s=600.0, step_s=3.0, length_s=10_000.0)[:3])) == ()  # an incubator
    assert suspicions(Run.of("loop", None, *(Series(run()[0], values) for values in run(seed)[2:]))) == ()


def test_milliseconds() -> None:
    time_s, *others = run()
    (told,) = suspicions(made(1e3 * time_s, *others))
    assert "r: a sample every 100 s and a response over" in told
    assert "is the time in ms? Divide it by 1000, or: lce import FILE --column time=NAME:ms" in told


def test_milliwatts() -> None:
    time_s, power, *others = run()
    (told,) = suspicions(made(time_s, 1e3 * power, *others))
    assert "1000 W warm by" in told and "--column power=NAME:mW" in told


def test_kelvin() -> None:
    time_s, power, temperature, moved = run()
    (told,) = suspicions(made(time_s, power, temperature + 273.15, moved))
    assert "never below 296 °C; is it in kelvin?" in told and "--column temperature=NAME:K" in told


def test_a_displacement_of_the_other_sign() -> None:
    time_s, power, temperature, moved = run()
    (told,) = suspicions(made(time_s, power, temperature, 1e-3 - moved))
    assert "the displacement falls while the temperature rises" in told and "displacement=NAME:-mm" in told


def test_a_temperature_that_falls_under_power() -> None:
    time_s, power, temperature, _ = run()
    (told,) = suspicions(made(time_s, power, 600.0 - temperature))
    assert "the temperature falls while the power is on" in told


def test_a_gap_matters_only_under_power() -> None:
    time_s, power, temperature, moved = run()
    for off, expected in ((False, 1), (True, 0)):
        kept = (time_s < 10.0) | (time_s > 28.0)
        used = np.where(time_s < 10.0, 0.0, power) if off else power
        told = suspicions(made(time_s[kept], used[kept], temperature[kept], moved[kept]))
        told = tuple(sentence for sentence in told if "nothing was recorded" in sentence)
        assert len(told) == expected
    kept = (time_s < 10.0) | (time_s > 28.0)
    (told,) = suspicions(made(time_s[kept], power[kept], temperature[kept], moved[kept]))
    assert "from 9.9 to 28.1 s, and 1 W count as held for all that time. Split the recording there" in told
