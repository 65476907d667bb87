# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

from lce_drivers.sensor import Reading
from lce_drivers.simulation.sensor import Imperfection, SimulatedSensor

PERFECT = Imperfection(0.0, 0.0, 0.0)


def readings(sensor: SimulatedSensor, truths: list[float], period_s: float = 0.01) -> list[Reading]:
    return [r for k, truth in enumerate(truths) for r in sensor.observe(truth, k * period_s)]


def test_a_perfect_sensor_tells_the_truth() -> None:
    found = readings(SimulatedSensor(PERFECT, 1, "x"), [1.0, 2.0, 3.0])
    assert [(r.value, r.t_s) for r in found] == [(1.0, 0.0), (2.0, 0.01), (3.0, 0.02)]


def test_noise_has_the_given_rms_and_no_mean() -> None:
    found = readings(SimulatedSensor(Imperfection(0.06, 0.0, 0.0), 1, "x"), [300.0] * 20000)
    values = np.array([r.value for r in found]) - 300.0
    assert abs(values.std() / 0.06 - 1.0) < 0.02
    assert abs(values.mean()) < 0.06 * 4 / math.sqrt(20000)
    assert found[0].variance == pytest.approx(0.0036)


def test_the_same_seed_gives_the_same_noise_and_another_stream_another() -> None:
    noisy = Imperfection(1.0, 0.0, 0.0)
    a, b, c = (
        [r.value for r in readings(SimulatedSensor(noisy, 5, stream), [0.0] * 100)] for stream in ("x", "x", "y")
    )
    assert a == b
    assert abs(np.corrcoef(a, c)[0, 1]) < 0.3


def test_the_noise_of_a_reading_depends_on_its_number_not_on_its_time() -> None:
    noisy = Imperfection(1.0, 0.0, 0.0)
    a = [r.value for r in readings(SimulatedSensor(noisy, 5, "x"), [0.0] * 10, period_s=0.01)]
    b = [r.value for r in readings(SimulatedSensor(noisy, 5, "x"), [0.0] * 10, period_s=0.013)]
    assert a == b


def test_values_are_rounded_to_the_quantum() -> None:
    found = readings(SimulatedSensor(Imperfection(0.0, 0.01, 0.0), 1, "x"), [1.234, 1.2361])
    assert [r.value for r in found] == pytest.approx([1.23, 1.24])


def test_every_tenth_sample_at_multiples_of_the_period() -> None:
    found = readings(SimulatedSensor(PERFECT, 1, "x", rate_hz=10.0), [float(k) for k in range(101)])
    assert [r.value for r in found] == [10.0 * k for k in range(11)]


def test_a_sample_at_an_epoch_time_is_still_on_its_multiple() -> None:
    sensor = SimulatedSensor(PERFECT, 1, "x", rate_hz=10.0)
    start = 1_763_686_860.0
    found = [r for k in range(100) for r in sensor.observe(float(k), round(start + k * 0.01, 7))]
    assert [r.value for r in found] == [10.0 * k for k in range(10)]


def test_latency_delays_the_reading_and_keeps_its_time() -> None:
    sensor = SimulatedSensor(Imperfection(0.0, 0.0, 0.03), 1, "x", rate_hz=10.0)
    seen = {k: sensor.observe(float(k), k * 0.01) for k in range(15)}
    assert {k: [(r.value, r.t_s) for r in v] for k, v in seen.items() if v} == {
        3: [(0.0, 0.0)],
        13: [(10.0, 0.1)],
    }


def test_a_strip_that_is_nowhere_is_not_measured() -> None:
    assert readings(SimulatedSensor(PERFECT, 1, "x"), [math.nan, 1.0]) == [Reading(1.0, 0.01)]


@pytest.mark.parametrize("index", [0, 1, 2])
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_an_impossible_imperfection_is_refused(index: int, value: float) -> None:
    arguments = [0.0, 0.0, 0.0]
    arguments[index] = value
    with pytest.raises(ValueError, match=Imperfection.__slots__[index]):
        Imperfection(*arguments)
