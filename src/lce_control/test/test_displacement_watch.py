# SPDX-License-Identifier: Apache-2.0
"""A distance sensor that is silent or repeats itself is a fault until it is reset; one that measures is none."""

import numpy as np
import pytest

from lce_control.displacement_watch import DisplacementWatch
from lce_control.filters import Sample

PERIOD_S = 0.01


def _measured(watch: DisplacementWatch, seconds: float, noise_m: float, quantum_m: float, seed: int = 0) -> None:
    """Let the watch see a strip at rest, and judge it at every sample."""
    rng = np.random.default_rng(seed)
    for k, value in enumerate(1e-3 + noise_m * rng.standard_normal(round(seconds / PERIOD_S))):
        watch.take(Sample(round(value / quantum_m) * quantum_m, k * PERIOD_S))
        watch.judge(k * PERIOD_S)


def _repeated(watch: DisplacementWatch, begin_s: float, seconds: float) -> float:
    """When a sensor that repeats 1 mm is found out [s]; infinite if it is not."""
    for t_s in np.arange(begin_s, begin_s + seconds, PERIOD_S):
        watch.take(Sample(1e-3, t_s))
        if watch.judge(t_s):
            return float(t_s)
    return np.inf


@pytest.mark.parametrize("seed", range(3))
def test_the_noise_of_the_bench_is_no_fault_in_an_hour(seed: int) -> None:
    watch = DisplacementWatch()
    _measured(watch, 3600.0, 4e-6, 1e-6, seed)
    assert watch.fault == ""


def test_a_sensor_that_repeats_itself_is_found_out_in_time() -> None:
    watch = DisplacementWatch()
    _measured(watch, 1.0, 4e-6, 1e-6)
    assert _repeated(watch, 1.0, 1.0) == pytest.approx(1.15)
    assert watch.fault == "the distance sensor has repeated 1.0000 mm for 0.15 s; is it frozen?"


def test_a_fault_stays_until_the_reset_and_comes_back_at_once_while_its_cause_is_there() -> None:
    watch = DisplacementWatch()
    end_s = _repeated(watch, 0.0, 1.0)
    watch.reset()
    assert watch.judge(end_s) != ""
    watch.take(Sample(1.1e-3, end_s + PERIOD_S))
    assert watch.judge(end_s + PERIOD_S) != ""
    watch.reset()
    assert watch.judge(end_s + PERIOD_S) == ""


def test_silence_is_a_fault_but_not_before_the_first_sample() -> None:
    watch = DisplacementWatch()
    assert watch.judge(100.0) == ""
    watch.take(Sample(1e-3, 100.0))
    assert watch.judge(100.5) == ""
    assert watch.judge(100.51) == "no displacement for 0.51 s"


def test_few_samples_that_are_far_apart_are_not_frozen() -> None:
    watch = DisplacementWatch(silent_after_s=10.0)
    for t_s in range(5):
        watch.take(Sample(1e-3, float(t_s)))
    assert watch.judge(4.0) == ""


def test_zero_is_for_a_sensor_without_noise() -> None:
    assert _repeated(DisplacementWatch(frozen_after_s=0.0), 0.0, 10.0) == np.inf
