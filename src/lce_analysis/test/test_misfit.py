# SPDX-License-Identifier: Apache-2.0
"""The one metric: squared errors in units of the sensor's noise, the same as in `lce compare`."""

from collections.abc import Callable

import numpy as np
import pytest

from lce_analysis.comparison.compare import compare
from lce_analysis.diagnosis.misfit import JudgedRuns, Misfit, Pair, reduction, reduction_of, share_removed
from lce_analysis.jumps import away_from, discontinuities
from lce_analysis.options import CompareOptions, Drive
from lce_analysis.prediction import predict
from lce_data.channels import DISPLACEMENT, SENSORS, TEMPERATURE
from lce_data.run import Run
from lce_model import Model


def _misfit(temperature: float, displacement: float | None = None, samples: float = 100.0) -> Misfit:
    """One run with these mean squares."""
    squares = {TEMPERATURE: temperature} | ({} if displacement is None else {DISPLACEMENT: displacement})
    return Misfit({c: np.array([x * samples]) for c, x in squares.items()}, {c: np.array([samples]) for c in squares})


@pytest.fixture
def pulse(recorded: Callable[..., Run]) -> Run:
    """The light goes off while the strip is inside its loop: the model jumps from one branch to the other."""
    return recorded(power=lambda t: np.where((t > 1.0) & (t < 9.0), 1.0, 0.0), duration_s=40.0)


@pytest.fixture
def without_loop(strip: Model) -> Model:
    """The strip with one branch, on which it never jumps."""
    one = {f"equilibrium.{name}_c": strip[f"equilibrium.{name}_r"] for name in ("c", "t_star", "a1", "a3")}
    return strip.set(one)


def test_pure_noise_has_a_mean_square_of_one(strip: Model, recorded: Callable[..., Run]) -> None:
    runs = [recorded(seed=seed) for seed in range(3)]
    judged = JudgedRuns.of(runs)
    misfit = judged.misfit(strip)
    for channel in SENSORS:
        assert misfit.mean_square(channel) == pytest.approx(1.0, abs=0.1)
        assert misfit.samples[channel].tolist() == [run.series[channel].value.size for run in runs]
    for noise in judged.noise:
        assert noise == pytest.approx({TEMPERATURE: 0.06, DISPLACEMENT: 4e-6}, rel=0.15)


@pytest.mark.parametrize("drive", ["model", "measured"])
def test_it_is_what_compare_tells(strip: Model, recorded: Callable[..., Run], drive: Drive) -> None:
    runs = [recorded("pulse"), recorded("thermal", seed=1, displacement=False)]
    model = strip.set({"lumped.tau": 18.4, "stretch_law.alpha": 1.93})
    misfit = JudgedRuns.of(runs).misfit(model, drive)
    compared = compare(model, runs, CompareOptions(drive=drive)).runs
    for channel in SENSORS:
        told = np.sqrt(misfit.total[channel] / misfit.samples[channel])
        wanted = [run.channels[channel].metrics.over_noise for run in compared if channel in run.channels]
        assert told == pytest.approx(wanted, rel=1e-9)


def test_errors_of_further_runs_stand_behind(strip: Model, recorded: Callable[..., Run]) -> None:
    both = JudgedRuns.of([recorded("pulse"), recorded("thermal", seed=1, displacement=False)])
    together, added = both.misfit(strip), both.only(0).misfit(strip) + both.only(1).misfit(strip)
    for channel, count in ((TEMPERATURE, 2), (DISPLACEMENT, 1)):
        assert added.total[channel].shape == (count,)
        np.testing.assert_array_equal(added.total[channel], together.total[channel])
        np.testing.assert_array_equal(added.samples[channel], together.samples[channel])


@pytest.mark.parametrize("swapped", [False, True])
def test_a_pair_is_judged_away_from_the_jumps_of_either_model(
    strip: Model, without_loop: Model, pulse: Run, swapped: bool
) -> None:
    judged, time = JudgedRuns.of([pulse]), pulse.series[DISPLACEMENT].time_s
    noise = judged.noise[0][DISPLACEMENT]
    jumps = discontinuities(time, predict(strip, pulse).at_samples[DISPLACEMENT], noise)
    assert jumps.size > 0
    assert discontinuities(time, predict(without_loop, pulse).at_samples[DISPLACEMENT], noise).size == 0
    models = (without_loop, strip) if swapped else (strip, without_loop)
    pair = judged.pair(*models, "model", SENSORS)
    away = away_from(jumps, time)
    for whole, part, model in zip(
        (pair.before, pair.after), (pair.judged_before, pair.judged_after), models, strict=True
    ):
        residual = (predict(model, pulse).at_samples[DISPLACEMENT] - pulse.series[DISPLACEMENT].value) / noise
        assert whole.total[DISPLACEMENT] == pytest.approx([residual @ residual])
        assert part.samples[DISPLACEMENT] == [away.sum()]
        assert part.total[DISPLACEMENT] == pytest.approx([residual[away] @ residual[away]])
        assert part.total[TEMPERATURE] == whole.total[TEMPERATURE]  # a temperature never jumps
        assert part.samples[TEMPERATURE] == whole.samples[TEMPERATURE]


def test_a_pair_is_judged_away_from_the_measured_jumps(without_loop: Model, pulse: Run) -> None:
    judged, series = JudgedRuns.of([pulse]), pulse.series[DISPLACEMENT]
    jumps = discontinuities(series.time_s, series.value, judged.noise[0][DISPLACEMENT])
    assert jumps == pytest.approx([9.01])
    pair = judged.pair(without_loop, without_loop.set({"stretch_law.alpha": 2.0}), "model", [DISPLACEMENT])
    assert pair.before.samples[DISPLACEMENT] == [series.value.size]
    assert pair.judged_before.samples[DISPLACEMENT] == [away_from(jumps, series.time_s).sum()]


def test_a_pair_without_jumps_is_judged_on_every_sample(without_loop: Model, recorded: Callable[..., Run]) -> None:
    other = without_loop.set({"stretch_law.alpha": 2.0})
    heating = recorded(power=lambda t: np.where(t > 1.0, 1.0, 0.0), duration_s=20.0)
    pair = JudgedRuns.of([heating]).pair(without_loop, other, "model", [DISPLACEMENT])
    assert set(pair.before.total) == {DISPLACEMENT}
    assert pair.judged_before.samples[DISPLACEMENT] == pair.before.samples[DISPLACEMENT]
    assert pair.judged_after.total[DISPLACEMENT] == pair.after.total[DISPLACEMENT]


def test_pairs_of_further_runs_stand_behind() -> None:
    first, second = _misfit(2.0, 3.0), _misfit(4.0)
    pair = Pair(first, first, first, first) + Pair(second, second, second, second)
    assert pair.judged_after.mean_square(TEMPERATURE) == 3.0
    assert pair.before.mean_square(DISPLACEMENT) == 3.0


def test_only_what_is_above_the_noise_counts() -> None:
    before, after = _misfit(5.0, 1.0), _misfit(2.0, 1.0)
    assert share_removed(before, after, TEMPERATURE) == pytest.approx(0.75)
    assert share_removed(before, after, DISPLACEMENT) == 0.0
    assert reduction(before, after, SENSORS) == pytest.approx(0.75)
    assert reduction(_misfit(5.0, 0.9), _misfit(2.0, 0.5), SENSORS) == pytest.approx(0.75)
    assert share_removed(before, _misfit(6.0), TEMPERATURE) == pytest.approx(-0.25)


def test_a_model_that_comes_below_the_noise_as_estimated_has_removed_all() -> None:
    assert share_removed(_misfit(5.0), _misfit(0.5), TEMPERATURE) == 1.0
    assert share_removed(_misfit(0.98), _misfit(0.9), TEMPERATURE) == 1.0
    assert share_removed(_misfit(0.9), _misfit(0.9), TEMPERATURE) == 0.0


def test_a_sensor_with_many_samples_counts_no_more_than_one_with_few() -> None:
    before = Misfit(
        {TEMPERATURE: np.array([300.0]), DISPLACEMENT: np.array([3000.0])},
        {TEMPERATURE: np.array([100.0]), DISPLACEMENT: np.array([1000.0])},
    )
    after = Misfit({TEMPERATURE: np.array([100.0]), DISPLACEMENT: np.array([3000.0])}, before.samples)
    assert reduction(before, after, SENSORS) == pytest.approx(0.5)
    assert reduction(before, after, [DISPLACEMENT]) == pytest.approx(0.0)


def test_an_error_that_grows_out_of_the_noise_counts_against() -> None:
    assert reduction_of({TEMPERATURE: 3.0, DISPLACEMENT: 1.0}, {TEMPERATURE: 1.0, DISPLACEMENT: 2.0}) == pytest.approx(
        0.5
    )
    assert reduction_of({TEMPERATURE: 0.8}, {TEMPERATURE: 7.0}) == 0.0  # nothing was above the noise
