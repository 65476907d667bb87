# SPDX-License-Identifier: Apache-2.0
"""What a model says of a run: on which grid, from which start, driven by what."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from lce_analysis.comparison.compare import compare
from lce_analysis.prediction import (
    Sampling,
    predict,
    predict_from,
    simulation_input,
    smoothed,
    start_temperature,
    starts_at,
)
from lce_data.channels import DISPLACEMENT, POWER, TEMPERATURE, Channel
from lce_data.errors import LceError
from lce_data.run import Run, Series
from lce_model import Model, default_model, simulate

Record = Callable[..., Run]


def test_sampling_is_linear_between_and_holds_the_ends() -> None:
    at = Sampling.between(np.array([0.0, 1.0, 3.0]), np.array([-1.0, 0.5, 2.0, 3.0, 9.0]))
    assert at(np.array([0.0, 10.0, 30.0])) == pytest.approx([0.0, 5.0, 20.0, 30.0, 30.0])
    assert at(np.zeros((4, 3))).shape == (4, 5)


def test_the_model_that_made_a_run_predicts_it_to_the_noise(strip: Model, recorded: Record) -> None:
    run = recorded(duration_s=40.0)
    found = predict(strip, run)
    assert run.temperature is not None and run.displacement is not None
    assert np.std(found.at_samples[TEMPERATURE] - run.temperature.value) == pytest.approx(0.06, rel=0.1)
    assert np.std(found.at_samples[DISPLACEMENT] - run.displacement.value) == pytest.approx(4e-6, rel=0.05)


def test_power_is_held_from_sample_to_sample(strip: Model, recorded: Record) -> None:
    run = recorded(duration_s=40.0)
    assert run.power is not None
    changes = np.append(np.flatnonzero(np.diff(run.power.value, prepend=np.nan)), run.power.time_s.size - 1)
    seldom = Series(run.power.time_s[changes], run.power.value[changes])
    dense, sparse = predict(strip, run), predict(strip, run.with_series(POWER, seldom))
    assert sparse.temperature_k[:-1] == pytest.approx(dense.temperature_k[changes[:-1]], abs=1e-6)


def test_sensors_that_outlive_the_power_are_predicted_to_their_end(strip: Model, recorded: Record) -> None:
    run = recorded(duration_s=40.0)
    assert run.power is not None and run.displacement is not None
    short = run.with_series(POWER, Series(run.power.time_s[:3000], run.power.value[:3000]))
    found = predict(strip, short)
    assert found.time_s[-1] == run.displacement.time_s[-1]
    assert found.temperature_k[-1] < found.temperature_k[2999]  # still dark


def test_a_run_at_rest_starts_exactly_at_the_ambient_temperature(strip: Model, recorded: Record) -> None:
    run_input = simulation_input(recorded(duration_s=20.0), strip)
    ambient = strip["ambient.t_env"]
    assert run_input.start_k != ambient  # of noisy samples
    assert starts_at(run_input, ambient)
    assert start_temperature(run_input, strip) == ambient
    assert not starts_at(run_input, ambient + 1.0)


def test_a_run_that_starts_warm_starts_where_all_samples_say(strip: Model, recorded: Record) -> None:
    run = recorded(duration_s=60.0)
    later = 15.0
    cut = {
        channel: Series(s.time_s[s.time_s >= later] - later, s.value[s.time_s >= later])
        for channel, s in run.series.items()
    }
    time = np.arange(0.0, 60.0, 0.01)
    truth = np.interp(
        later, time, simulate(strip, time, np.where((time > 1.0) & (time < 25.0), 1.3, 0.0)).temperature_k
    )
    warm = replace(run, series=cut)
    # Nearer than the first camera sample alone (0.06 K) could be trusted to be.
    assert start_temperature(simulation_input(warm, strip), strip) == pytest.approx(truth, abs=0.02)


def test_the_measured_temperature_drives_without_its_noise(strip: Model, recorded: Record) -> None:
    run = recorded(duration_s=40.0)
    assert run.displacement is not None
    found = predict(strip, run, "measured")
    rms = float(np.sqrt(np.mean((found.at_samples[DISPLACEMENT] - run.displacement.value) ** 2)))
    assert rms < 30e-6  # 0.06 K on the slope of the loop would be more than 5 µm, a flickering branch 1 mm
    bare = predict(strip, run.with_series(POWER, None))  # a bare T–d loop
    assert TEMPERATURE not in bare.at_samples
    assert DISPLACEMENT in bare.at_samples


def test_smoothing_keeps_the_corners_that_the_model_knows() -> None:
    time = np.arange(0.0, 40.0, 0.1)
    corner = 10.0 * np.abs(time - 20.0)
    noise = 0.06 * np.random.default_rng(0).standard_normal(time.size)
    alone = smoothed(Series(time, corner + noise))
    around = smoothed(Series(time, corner + noise), corner + 0.2)
    near = np.abs(time - 20.0) < 0.5
    assert np.abs(around - corner)[near].max() < 0.05 < np.abs(alone - corner)[near].max()
    assert np.std(around - corner) < 0.02


def test_a_run_without_any_input(strip: Model, recorded: Record) -> None:
    """As a user may build one; `read_runs` refuses such a recording."""
    displaced = recorded(duration_s=10.0).displacement
    with pytest.raises(LceError, match="x: neither laser power nor temperature was recorded"):
        compare(strip, [Run.of("x", displacement=displaced)])


def test_a_prediction_from_the_prepared_run_is_that_of_predict(strip: Model, recorded: Record) -> None:
    run = recorded(duration_s=20.0)
    run_input = simulation_input(run, strip)
    found = predict_from(run_input, start_temperature(run_input, strip), strip)
    for channel, values in predict(strip, run).at_samples.items():
        assert np.array_equal(found.at_samples[channel], values)
    slower = predict_from(run_input, found.start_temperature_k, strip.set({"lumped.tau": 2.0 * strip["lumped.tau"]}))
    assert slower.temperature_k.max() < found.temperature_k.max()


@pytest.mark.parametrize(
    ("model", "missing", "told"),
    [
        (
            default_model("lumped", "none"),
            POWER,
            "no laser power was recorded, and the model has only a thermal stage",
        ),
        (default_model("none", "equilibrium"), TEMPERATURE, "has no thermal stage, and no temperature was measured"),
    ],
)
def test_a_run_without_what_the_model_needs(model: Model, missing: Channel, told: str, recorded: Record) -> None:
    with pytest.raises(LceError, match=f"pulse: .*{told}"):
        predict(model, recorded(duration_s=10.0).with_series(missing, None))
